// SPDX-License-Identifier: BSD-2-Clause
#include <exception>

#include "bindings.h"
#include "run.h"

#include "facet/facet.h"
#include "facet/io/errors.h"

namespace py = pybind11;

namespace facet::python {
namespace {

/// A class of exceptions in the module, below `base`. It lives as long as the interpreter.
PyObject* NewException(py::module_& module, const char* name, PyObject* base, const char* doc) {
  const std::string full_name = std::string("facet.") + name;
  PyObject* type = PyErr_NewExceptionWithDoc(full_name.c_str(), doc, base, nullptr);
  if (type == nullptr) throw py::error_already_set();
  module.attr(name) = py::reinterpret_borrow<py::object>(type);
  return type;
}

struct Types {
  PyObject *error, *config, *input, *output, *run_ended;
};
Types types;

void RaiseRunEnded(const RunEndedError& error) {
  const py::object raised =
      py::reinterpret_borrow<py::object>(types.run_ended)(std::string(error.what()));
  raised.attr("exit_code") = error.exit_code();
  PyErr_SetObject(types.run_ended, raised.ptr());
}

void Translate(std::exception_ptr pointer) {
  try {
    if (pointer) std::rethrow_exception(pointer);
  } catch (const ConfigError& error) {
    PyErr_SetString(types.config, error.what());
  } catch (const InputError& error) {
    PyErr_SetString(types.input, error.what());
  } catch (const OutputError& error) {
    PyErr_SetString(types.output, error.what());
  } catch (const RunEndedError& error) {
    RaiseRunEnded(error);
  } catch (const api::Error& error) {
    PyErr_SetString(types.error, error.what());
  }
}

}  // namespace

void BindErrors(py::module_& module) {
  types.error =
      NewException(module,
                   "Error",
                   PyExc_RuntimeError,
                   "What is wrong with a file, an option or a calibration, and what to do.");
  types.config = NewException(module,
                              "ConfigError",
                              types.error,
                              "Wrong usage or parameters (exit code 2 of the program).");
  types.input = NewException(
      module, "InputError", types.error, "A file is missing or damaged (exit code 3).");
  types.output =
      NewException(module, "OutputError", types.error, "A file cannot be written (exit code 5).");
  types.run_ended = NewException(
      module,
      "RunEnded",
      types.error,
      "A run ended early, after the results up to then were written: `exit_code` as the program's, "
      "`result` has what there is.");
  py::register_exception_translator(&Translate);
}

}  // namespace facet::python
