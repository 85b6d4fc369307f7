// SPDX-License-Identifier: BSD-2-Clause
#include "facet/io/ply_reader.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

#include "facet/io/errors.h"

namespace facet {
namespace {

enum class Type { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

struct Property {
  std::string name;
  Type type = Type::kFloat32;
  std::optional<Type> count_type;  // of a list
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  bool is_ascii = false;
  std::vector<Element> elements;
  std::size_t size = 0;  // bytes up to the first value
  int num_lines = 0;
};

std::optional<Type> TypeFromText(std::string_view text) {
  constexpr std::pair<std::string_view, Type> kNames[] = {{"char", Type::kInt8},
                                                          {"int8", Type::kInt8},
                                                          {"uchar", Type::kUint8},
                                                          {"uint8", Type::kUint8},
                                                          {"short", Type::kInt16},
                                                          {"int16", Type::kInt16},
                                                          {"ushort", Type::kUint16},
                                                          {"uint16", Type::kUint16},
                                                          {"int", Type::kInt32},
                                                          {"int32", Type::kInt32},
                                                          {"uint", Type::kUint32},
                                                          {"uint32", Type::kUint32},
                                                          {"float", Type::kFloat32},
                                                          {"float32", Type::kFloat32},
                                                          {"double", Type::kFloat64},
                                                          {"float64", Type::kFloat64}};
  for (const auto& [name, type] : kNames) {
    if (text == name) return type;
  }
  return std::nullopt;
}

std::size_t SizeOf(Type type) {
  switch (type) {
    case Type::kInt8:
    case Type::kUint8:
      return 1;
    case Type::kInt16:
    case Type::kUint16:
      return 2;
    case Type::kInt32:
    case Type::kUint32:
    case Type::kFloat32:
      return 4;
    case Type::kFloat64:
      return 8;
  }
  return 0;
}

template <class T>
double Load(const char* bytes) {
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return static_cast<double>(value);
}

double LoadAs(Type type, const char* bytes) {
  switch (type) {
    case Type::kInt8:
      return Load<std::int8_t>(bytes);
    case Type::kUint8:
      return Load<std::uint8_t>(bytes);
    case Type::kInt16:
      return Load<std::int16_t>(bytes);
    case Type::kUint16:
      return Load<std::uint16_t>(bytes);
    case Type::kInt32:
      return Load<std::int32_t>(bytes);
    case Type::kUint32:
      return Load<std::uint32_t>(bytes);
    case Type::kFloat32:
      return Load<float>(bytes);
    case Type::kFloat64:
      return Load<double>(bytes);
  }
  return 0;
}

bool IsSpace(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

// ------------------------------------------------------------------------------------- header

class HeaderParser {
 public:
  HeaderParser(std::string file, std::string_view content)
      : file_(std::move(file)), content_(content) {}

  Header Parse() {
    if (NextLine() != "ply") Fail("is not a PLY file (the first line must be 'ply')");
    while (true) {
      if (header_.size >= content_.size()) Fail("the header has no end_header");
      std::istringstream words(NextLine());
      std::string keyword;
      words >> keyword;
      if (keyword == "end_header") break;
      if (keyword == "format") ParseFormat(words);
      if (keyword == "element") ParseElement(words);
      if (keyword == "property") ParseProperty(words);
    }
    if (!has_format_) Fail("the header has no format line");
    return std::move(header_);
  }

 private:
  std::string NextLine() {
    const std::size_t end = std::min(content_.find('\n', header_.size), content_.size());
    std::string line(content_.substr(header_.size, end - header_.size));
    if (!line.empty() && line.back() == '\r') line.pop_back();
    header_.size = std::min(end + 1, content_.size());
    ++header_.num_lines;
    return line;
  }

  void ParseFormat(std::istream& words) {
    std::string format;
    words >> format;
    if (format != "ascii" && format != "binary_little_endian") {
      Fail("format '" + format + "' is not supported; save it as ascii or binary_little_endian");
    }
    header_.is_ascii = format == "ascii";
    has_format_ = true;
  }

  void ParseElement(std::istream& words) {
    Element element;
    std::string count_text, more;
    words >> element.name >> count_text >> more;
    // Digits only: "1e9" must not be read as 1.
    const char* end = count_text.data() + count_text.size();
    const auto [stop, error] = std::from_chars(count_text.data(), end, element.count);
    if (element.name.empty() || error != std::errc() || stop != end || !more.empty()) {
      Fail("'element NAME COUNT' is expected, with a whole number in digits, not 'element " +
           element.name + " " + count_text + (more.empty() ? "" : " " + more) + "'");
    }
    header_.elements.push_back(std::move(element));
  }

  void ParseProperty(std::istream& words) {
    if (header_.elements.empty()) Fail("a property before the first element");
    Property property;
    std::string type;
    words >> type;
    if (type == "list") {
      std::string count_type;
      words >> count_type >> type;
      property.count_type = TypeFromText(count_type);
      if (!property.count_type) Fail("unknown type '" + count_type + "'");
    }
    words >> property.name;
    const auto value_type = TypeFromText(type);
    if (!value_type || property.name.empty()) Fail("unknown property type '" + type + "'");
    property.type = *value_type;
    header_.elements.back().properties.push_back(std::move(property));
  }

  [[noreturn]] void Fail(const std::string& message) const {
    throw InputError(file_ + ":" + std::to_string(header_.num_lines) + ": " + message);
  }

  std::string file_;
  std::string_view content_;
  Header header_;
  bool has_format_ = false;
};

// ------------------------------------------------------------------------------------- values

// Hands out the numbers behind the header one by one.
class Values {
 public:
  Values(std::string file, std::string_view content, const Header& header)
      : file_(std::move(file)),
        content_(content),
        position_(header.size),
        line_(header.num_lines + 1),
        is_ascii_(header.is_ascii) {}

  // The item is what an error names: "vertex 17".
  void Begin(const std::string& element, std::size_t index) {
    element_ = &element;
    index_ = index;
  }

  double Next(Type type) { return is_ascii_ ? NextWord() : NextBytes(type); }

  std::size_t num_bytes_left() const { return content_.size() - position_; }

  [[noreturn]] void Fail(const std::string& message) const {
    const std::string where = is_ascii_ ? ":" + std::to_string(line_) : "";
    throw InputError(file_ + where + ": " + *element_ + " " + std::to_string(index_) + ": " +
                     message);
  }

 private:
  double NextBytes(Type type) {
    const std::size_t size = SizeOf(type);
    if (size > num_bytes_left()) Fail("the file ends here, it is incomplete");
    const double value = LoadAs(type, content_.data() + position_);
    position_ += size;
    return value;
  }

  double NextWord() {
    while (position_ < content_.size() && IsSpace(content_[position_])) {
      if (content_[position_++] == '\n') ++line_;
    }
    const std::size_t begin = position_;
    while (position_ < content_.size() && !IsSpace(content_[position_]))
      ++position_;
    if (begin == position_) Fail("the file ends here, it is incomplete");
    double value = 0;
    const char* end = content_.data() + position_;
    const auto [stop, error] = std::from_chars(content_.data() + begin, end, value);
    if (error != std::errc() || stop != end) {
      Fail("'" + std::string(content_.substr(begin, position_ - begin)) + "' is not a number");
    }
    return value;
  }

  std::string file_;
  std::string_view content_;
  std::size_t position_;
  int line_;
  bool is_ascii_;
  const std::string* element_ = nullptr;
  std::size_t index_ = 0;
};

// Where a scalar property goes.
enum Slot { kX, kY, kZ, kNx, kNy, kNz, kRed, kGreen, kBlue, kSigma, kPlaneId, kNumSlots, kSkip };

Slot SlotOf(const std::string& name) {
  constexpr std::string_view kNames[kNumSlots] = {
      "x", "y", "z", "nx", "ny", "nz", "red", "green", "blue", "sigma_m", "plane_id"};
  for (int i = 0; i < kNumSlots; ++i) {
    if (name == kNames[i]) return static_cast<Slot>(i);
  }
  return kSkip;
}

class MeshReader {
 public:
  MeshReader(const std::string& file, std::string_view content, const Header& header)
      : values_(file, content, header) {
    for (const Element& element : header.elements) {
      if (element.name == "vertex") num_vertices_ = element.count;
    }
    if (num_vertices_ > kMaxVertices) {
      throw InputError(file + ": " + std::to_string(num_vertices_) + " vertices; at most " +
                       std::to_string(kMaxVertices) + " can be read");
    }
  }

  void Read(const Element& element) {
    Prepare(element);
    for (std::size_t i = 0; i < element.count; ++i) {
      values_.Begin(element.name, i);
      list_.clear();
      for (std::size_t p = 0; p < element.properties.size(); ++p)
        ReadProperty(element, p);
      if (element.name == "vertex") AddVertex();
      if (element.name == "face") AddFace();
    }
  }

  TriangleMesh TakeMesh() { return std::move(mesh_); }

 private:
  void Prepare(const Element& element) {
    slots_.assign(element.properties.size(), kSkip);
    bool seen[kNumSlots] = {};
    for (std::size_t p = 0; p < slots_.size(); ++p) {
      slots_[p] = SlotOf(element.properties[p].name);
      if (slots_[p] != kSkip) seen[slots_[p]] = true;
    }
    has_normals_ = seen[kNx] && seen[kNy] && seen[kNz];
    has_colours_ = seen[kRed] && seen[kGreen] && seen[kBlue];
    has_sigmas_ = seen[kSigma];
    has_plane_ids_ = seen[kPlaneId];
    values_.Begin(element.name, 0);
    if (element.name == "vertex" && !(seen[kX] && seen[kY] && seen[kZ])) {
      values_.Fail("the element has no x y z");
    }
    // Its items would take no bytes, so no end of the file would end a damaged count of them.
    if (element.count > 0 && element.properties.empty())
      values_.Fail("the element has no properties");
    // Every item takes at least a byte: a damaged count must not ask for all the memory.
    const std::size_t most = std::min(element.count, values_.num_bytes_left());
    if (element.name == "vertex") mesh_.vertices.reserve(most);
    if (element.name == "face") mesh_.faces.reserve(most);
  }

  void ReadProperty(const Element& element, std::size_t p) {
    const Property& property = element.properties[p];
    if (!property.count_type) {
      const double value = values_.Next(property.type);
      if (slots_[p] != kSkip) slot_values_[slots_[p]] = value;
      return;
    }
    const double count = values_.Next(*property.count_type);
    if (!(count >= 0) || count > static_cast<double>(values_.num_bytes_left())) {
      values_.Fail("a list of impossible length");
    }
    const bool is_face = property.name == "vertex_indices" || property.name == "vertex_index";
    for (std::size_t k = 0; k < static_cast<std::size_t>(count); ++k) {
      const double value = values_.Next(property.type);
      if (is_face) list_.push_back(value);
    }
  }

  void AddVertex() {
    const double* v = slot_values_;
    const Vector3d p(v[kX], v[kY], v[kZ]);
    if (!p.allFinite()) values_.Fail("the position is not finite");
    mesh_.vertices.push_back(p);
    if (has_normals_) mesh_.normals.emplace_back(v[kNx], v[kNy], v[kNz]);
    if (has_sigmas_) mesh_.sigma_m.push_back(static_cast<float>(v[kSigma]));
    if (!has_colours_) return;
    mesh_.colours.push_back({Byte(v[kRed]), Byte(v[kGreen]), Byte(v[kBlue])});
  }

  static std::uint8_t Byte(double value) {
    // The comparison is false for NaN.
    return static_cast<std::uint8_t>(value > 0 ? std::min(value, 255.0) : 0.0);
  }

  void AddFace() {
    for (double index : list_) {
      if (!(index >= 0) || index >= static_cast<double>(num_vertices_) ||
          index != std::floor(index)) {
        values_.Fail("has a vertex that does not exist; the file has " +
                     std::to_string(num_vertices_));
      }
    }
    const int plane_id = has_plane_ids_ ? PlaneId() : -1;
    for (std::size_t k = 2; k < list_.size(); ++k) {
      mesh_.faces.push_back(
          {static_cast<int>(list_[0]), static_cast<int>(list_[k - 1]), static_cast<int>(list_[k])});
      if (has_plane_ids_) mesh_.plane_ids.push_back(plane_id);
    }
  }

  int PlaneId() const {
    const double id = slot_values_[kPlaneId];
    constexpr double kMost = std::numeric_limits<int>::max();
    if (!(id >= -kMost && id <= kMost)) values_.Fail("the plane_id is no whole number");
    return static_cast<int>(id);
  }

  // Faces name them by int.
  static constexpr std::size_t kMaxVertices = std::numeric_limits<int>::max();

  Values values_;
  TriangleMesh mesh_;
  std::size_t num_vertices_ = 0;
  std::vector<Slot> slots_;
  double slot_values_[kNumSlots] = {};
  std::vector<double> list_;
  bool has_normals_ = false, has_colours_ = false, has_sigmas_ = false, has_plane_ids_ = false;
};

std::string ReadBytes(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) throw InputError(file.string() + ": no such file");
  if (std::filesystem::is_directory(file, error)) {
    throw InputError(file.string() + ": is a folder, a PLY file is expected");
  }
  if (!std::filesystem::is_regular_file(file, error))
    throw InputError(file.string() + ": is a pipe or a device, a PLY file is expected");
  std::ifstream stream(file, std::ios::binary);
  std::string content((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  if (!stream) throw InputError(file.string() + ": cannot be read (permissions?)");
  return content;
}

}  // namespace

TriangleMesh ReadPly(const std::filesystem::path& file) {
  static_assert(std::endian::native == std::endian::little, "values are read as they lie in files");
  const std::string content = ReadBytes(file);
  const Header header = HeaderParser(file.string(), content).Parse();
  MeshReader reader(file.string(), content, header);
  for (const Element& element : header.elements)
    reader.Read(element);
  TriangleMesh mesh = reader.TakeMesh();
  if (mesh.vertices.empty()) throw InputError(file.string() + ": holds no vertex");
  return mesh;
}

}  // namespace facet
