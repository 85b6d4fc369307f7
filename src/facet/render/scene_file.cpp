// SPDX-License-Identifier: BSD-2-Clause
#include "facet/render/scene_file.h"

#include <algorithm>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "facet/geometry/angles.h"
#include "facet/geometry/so3.h"
#include "facet/io/errors.h"
#include "facet/io/yaml_file.h"
#include "facet/render/furniture.h"

namespace facet {
namespace {

/// One entry of `objects`.
struct ObjectNode {
  const YamlFile& yaml;
  YAML::Node node;

  [[noreturn]] void Fail(const std::string& message) const { yaml.Fail(node, message); }

  std::vector<double> Numbers(const std::string& key, std::size_t count) const {
    const std::vector<double> numbers = yaml.Numbers(yaml.Require(node, key));
    if (numbers.size() != count)
      Fail("'" + key + "' must have " + std::to_string(count) + " numbers");
    return numbers;
  }
  double Number(const std::string& key, double fallback) const {
    return YamlFile::Has(node, key) ? yaml.RequireNumber(node, key) : fallback;
  }
  Vector3d Vector(const std::string& key) const {
    const std::vector<double> v = Numbers(key, 3);
    return {v[0], v[1], v[2]};
  }
  void CheckPositive(const std::string& key, double value) const {
    if (!(value > 1e-4)) Fail("'" + key + "' must be larger than 0.1 mm");
  }
  Vector3d Size3() const {
    const Vector3d size = Vector("size");
    CheckPositive("size", size.minCoeff());
    return size;
  }
  Vector2d Size2() const {
    const std::vector<double> v = Numbers("size", 2);
    CheckPositive("size", std::min(v[0], v[1]));
    return {v[0], v[1]};
  }
  double Radius() const {
    const double radius = yaml.RequireNumber(node, "radius");
    CheckPositive("radius", radius);
    return radius;
  }
};

/// A name of the library, or an image file relative to the scene file.
int ChooseMaterial(const ObjectNode& object, MaterialLibrary& materials, const char* fallback) {
  if (YamlFile::Has(object.node, "image")) {
    std::filesystem::path file = object.yaml.RequireText(object.node, "image");
    if (file.is_relative()) file = object.yaml.file().parent_path() / file;
    try {
      return materials.AddPicture(file);
    } catch (const InputError& error) {
      object.Fail(std::string("'image': ") + error.what());
    }
  }
  if (!YamlFile::Has(object.node, "material")) return materials.Get(fallback);
  const std::string name = object.yaml.RequireText(object.node, "material");
  const int index = materials.Find(name);
  if (index < 0) object.Fail("no material '" + name + "'; known: " + materials.Names());
  return index;
}

struct ObjMesh {
  std::vector<Vector3d> corners;
  std::vector<std::array<int, 3>> triangles;
};

/// `v` and `f` lines of a Wavefront OBJ file; polygons become fans.
ObjMesh ReadObj(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream) throw InputError(file.string() + ": cannot be opened");
  ObjMesh mesh;
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    const auto fail = [&](const char* why) {
      throw InputError(file.string() + ":" + std::to_string(number) + ": " + why);
    };
    if (kind == "v") {
      Vector3d p;
      if (!(words >> p.x() >> p.y() >> p.z()) || !p.allFinite()) fail("not three numbers");
      mesh.corners.push_back(p);
    } else if (kind == "f") {
      std::vector<int> indices;
      for (std::string word; words >> word;) {
        const int index = std::atoi(word.c_str());  // "7/1/2" counts as 7
        if (index < 1 || index > static_cast<int>(mesh.corners.size())) fail("unknown corner");
        indices.push_back(index - 1);
      }
      if (indices.size() < 3) fail("a face needs three corners");
      for (std::size_t i = 2; i < indices.size(); ++i)
        mesh.triangles.push_back({indices[0], indices[i - 1], indices[i]});
    }
  }
  const auto is_flat = [&](const std::array<int, 3>& t) {
    const Vector3d& a = mesh.corners[static_cast<std::size_t>(t[0])];
    const Vector3d& b = mesh.corners[static_cast<std::size_t>(t[1])];
    const Vector3d& c = mesh.corners[static_cast<std::size_t>(t[2])];
    return (b - a).cross(c - a).norm() < 1e-10;
  };
  const auto end = std::remove_if(mesh.triangles.begin(), mesh.triangles.end(), is_flat);
  mesh.triangles.erase(end, mesh.triangles.end());
  if (mesh.triangles.empty()) {
    throw InputError(file.string() + ": degenerate mesh: no triangle with an area");
  }
  return mesh;
}

using AddObject = void (*)(const ObjectNode&, const Spot&, MaterialLibrary&);

void AddObjFile(const ObjectNode& object, const Spot& spot, MaterialLibrary& materials) {
  std::filesystem::path file = object.yaml.RequireText(object.node, "file");
  if (file.is_relative()) file = object.yaml.file().parent_path() / file;
  const ObjMesh mesh = ReadObj(file);
  const int material = ChooseMaterial(object, materials, "concrete");
  spot.builder.Place(spot.T_WO);
  spot.builder.AddTriangles({"mesh", material, 0.1, true}, mesh.corners, mesh.triangles);
}

/// Object types with the keys they understand besides `type`, `at` and `yaw_deg`.
struct ObjectType {
  std::set<std::string> keys;
  AddObject add;
};

const std::map<std::string, ObjectType>& ObjectTypes() {
  static const std::map<std::string, ObjectType> types = {
      {"box",
       {{"size", "material", "image"},
        [](const ObjectNode& o, const Spot& s, MaterialLibrary& m) {
          const Vector3d size = o.Size3();
          s.builder.Place(s.T_WO);
          s.builder.AddBox({"box", ChooseMaterial(o, m, "cardboard")}, {0, 0, size.z() / 2}, size);
        }}},
      {"board",
       {{"size", "lean_deg", "material", "image"},
        [](const ObjectNode& o, const Spot& s, MaterialLibrary& m) {
          AddLeaningBoard(
              s, o.Size2(), ChooseMaterial(o, m, "boards"), o.Number("lean_deg", 8) * kDegree);
        }}},
      {"panel",
       {{"size", "material", "image"},
        [](const ObjectNode& o, const Spot& s, MaterialLibrary& m) {
          AddPanel(s, "panel", o.Size2(), ChooseMaterial(o, m, "rough_plaster"));
        }}},
      {"mat",
       {{"size", "material", "image"},
        [](const ObjectNode& o, const Spot& s, MaterialLibrary& m) {
          AddMat(s, "mat", o.Size2(), ChooseMaterial(o, m, "carpet"));
        }}},
      {"cylinder",
       {{"radius", "height", "material", "image"},
        [](const ObjectNode& o, const Spot& s, MaterialLibrary& m) {
          const double height = o.Number("height", 1);
          o.CheckPositive("height", height);
          s.builder.Place(s.T_WO);
          s.builder.AddCylinder({"cylinder", ChooseMaterial(o, m, "metal")}, o.Radius(), height);
        }}},
      {"sphere",
       {{"radius", "material", "image"},
        [](const ObjectNode& o, const Spot& s, MaterialLibrary& m) {
          s.builder.Place(s.T_WO);
          s.builder.AddSphere({"sphere", ChooseMaterial(o, m, "stone")}, o.Radius());
        }}},
      {"rock",
       {{"radius", "material", "image"},
        [](const ObjectNode& o, const Spot& s, MaterialLibrary& m) {
          s.builder.Place(s.T_WO);
          s.builder.AddBlob({"rock", ChooseMaterial(o, m, "stone"), 0.06}, o.Radius(), 0.18);
        }}},
      {"table",
       {{"size"},
        [](const ObjectNode& o, const Spot& s, MaterialLibrary&) { AddTable(s, o.Size3()); }}},
      {"shelf",
       {{"size"},
        [](const ObjectNode& o, const Spot& s, MaterialLibrary&) { AddShelf(s, o.Size3()); }}},
      {"chair", {{}, [](const ObjectNode&, const Spot& s, MaterialLibrary&) { AddChair(s); }}},
      {"plant",
       {{"height"},
        [](const ObjectNode& o, const Spot& s, MaterialLibrary&) {
          const double height = o.Number("height", 1);
          o.CheckPositive("height", height);
          AddPlant(s, height);
        }}},
      {"mesh", {{"file", "material", "image"}, AddObjFile}}};
  return types;
}

void AddOne(const ObjectNode& object, ShapeBuilder& builder, MaterialLibrary& materials) {
  const std::string type = object.yaml.RequireText(object.node, "type");
  const auto found = ObjectTypes().find(type);
  if (found == ObjectTypes().end()) {
    std::string names;
    for (const auto& [name, unused] : ObjectTypes())
      names += (names.empty() ? "" : ", ") + name;
    object.Fail("no object type '" + type + "'; known: " + names);
  }
  for (const auto& item : object.node) {
    const std::string key = item.first.as<std::string>();
    const bool is_common = key == "type" || key == "at" || key == "yaw_deg";
    if (!is_common && found->second.keys.count(key) == 0)
      object.yaml.Fail(item.first, "a '" + type + "' has no '" + key + "'");
  }
  const SE3 T_WO(ExpSO3(Vector3d(0, 0, object.Number("yaw_deg", 0) * kDegree)),
                 object.Vector("at"));
  found->second.add(object, {builder, T_WO}, materials);
}

void AddLights(const YamlFile& yaml, Lighting& lighting) {
  const YAML::Node& root = yaml.root();
  if (YamlFile::Has(root, "ambient")) lighting.ambient = yaml.RequireNumber(root, "ambient");
  if (!YamlFile::Has(root, "lights")) {
    lighting.lights.push_back({{0, 0, 3.5}, 0.4, 6});
    return;
  }
  for (const YAML::Node& node : root["lights"]) {
    const ObjectNode light{yaml, node};
    lighting.lights.push_back({light.Vector("at"),
                               std::max(0.01, light.Number("radius", 0.3)),
                               light.Number("power", 4)});
  }
}

}  // namespace

SceneModel ReadSceneFile(const std::filesystem::path& file,
                         std::uint64_t seed,
                         MaterialLibrary& materials) {
  const YamlFile yaml(file);
  static const std::set<std::string> kKeys = {"objects", "lights", "ambient", "route", "sky"};
  for (const auto& item : yaml.root()) {
    const std::string key = item.first.as<std::string>();
    if (kKeys.count(key) == 0)
      yaml.Fail(item.first,
                "unknown key '" + key + "'; known: ambient, lights, objects, route, sky");
  }
  const YAML::Node objects = yaml.Require(yaml.root(), "objects");
  if (!objects.IsSequence() || objects.size() == 0)
    yaml.Fail(objects, "'objects' must be a list of at least one object");
  ShapeBuilder builder(materials, Rng(seed));
  for (const YAML::Node& node : objects)
    AddOne({yaml, node}, builder, materials);
  SceneModel scene;
  AddLights(yaml, scene.lighting);
  if (YamlFile::Has(yaml.root(), "sky"))
    scene.lighting.sky = yaml.RequireNumber(yaml.root(), "sky");
  scene.mesh = builder.TakeMesh();
  return scene;
}

std::vector<Vector3d> ReadSceneRoute(const std::filesystem::path& file) {
  const YamlFile yaml(file);
  if (!YamlFile::Has(yaml.root(), "route")) {
    yaml.Fail(yaml.root(),
              "a made-up flight needs a 'route': a list of at least two points [x, y, z]");
  }
  const YAML::Node node = yaml.root()["route"];
  const std::vector<double> v = yaml.Numbers(node);
  if (v.size() < 6 || v.size() % 3 != 0)
    yaml.Fail(node, "'route' must be a list of at least two points [x, y, z]");
  std::vector<Vector3d> route_W;
  for (std::size_t i = 0; i < v.size(); i += 3)
    route_W.emplace_back(v[i], v[i + 1], v[i + 2]);
  return route_W;
}

}  // namespace facet
