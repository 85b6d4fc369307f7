# SPDX-License-Identifier: BSD-2-Clause
"""Stubs, docstrings and names say what is there."""

import ast
import inspect
import re
from importlib import resources

import facet
from facet import _native

STUBS = resources.files("facet").joinpath("_native.pyi").read_text()
OWN_OPERATORS = {"__init__", "__repr__", "__len__", "__iter__", "__next__"}


def stub_names(body):
    """Names that a stub defines, with the parameters of the functions."""
    names = {}
    for node in body:
        if isinstance(node, ast.FunctionDef):
            arguments = node.args.args + node.args.kwonlyargs
            names.setdefault(node.name, [a.arg for a in arguments if a.arg != "self"])
        elif isinstance(node, ast.AnnAssign):
            names[node.target.id] = None
        elif isinstance(node, ast.ClassDef):
            names[node.name] = node
    return names


def parameters_of(function):
    """From the first line of the docstring, where pybind11 writes the signature."""
    inside = re.search(r"\((.*)\) -> ", function.__doc__.splitlines()[0]).group(1)
    names = re.findall(r"(?:^|, )\*?(\w+):", inside)
    return [name for name in names if name != "self"]


def test_stubs_name_what_the_module_has():
    stubs = stub_names(ast.parse(STUBS).body)
    there = {name for name in vars(_native) if not name.startswith("__")} | {"__version__"}
    assert stubs.keys() == there
    for name, node in stubs.items():
        if isinstance(node, list):
            assert parameters_of(getattr(_native, name)) == node, name


def test_stubs_of_classes_name_what_the_classes_have():
    classes = [node for node in ast.parse(STUBS).body if isinstance(node, ast.ClassDef)]
    assert len(classes) == 13
    for node in classes:
        cls = getattr(_native, node.name)
        if issubclass(cls, Exception):
            continue
        there = {name for name in vars(cls) if not name.startswith("_") or name in OWN_OPERATORS}
        stubs = stub_names(node.body)
        init_is_ours = "Initialize self" not in (cls.__init__.__doc__ or "")
        assert stubs.keys() - {"__init__"} == there - {"__init__"}, node.name
        for name, parameters in stubs.items():
            member = inspect.getattr_static(cls, name)
            if isinstance(parameters, list) and not isinstance(member, property) and init_is_ours:
                assert parameters_of(member) == parameters, f"{node.name}.{name}"


def test_all_that_is_public_has_a_docstring():
    for name in facet.__all__:
        thing = getattr(facet, name)
        if name == "__version__":
            continue
        assert thing.__doc__ and len(thing.__doc__) > 20, name
        if inspect.isclass(thing) and not issubclass(thing, Exception):
            for method, member in vars(thing).items():
                if callable(member) and not method.startswith("_"):
                    assert member.__doc__, f"{name}.{method}"


def test_the_package_is_typed():
    assert resources.files("facet").joinpath("py.typed").is_file()
    assert re.fullmatch(r"\d+\.\d+\.\d+", facet.__version__)
    assert sorted(facet.__all__) == sorted(set(facet.__all__))


def test_exceptions_have_one_base():
    for name in ("ConfigError", "InputError", "OutputError", "RunEnded"):
        assert issubclass(getattr(facet, name), facet.Error)
    assert issubclass(facet.Error, RuntimeError)
