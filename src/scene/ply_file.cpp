#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <optional>

#include "deformable_sim/core/error.h"
#include "face_files.h"

namespace deformable_sim {
namespace {

enum class Type { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat, kDouble };

struct Property {
  std::string name;
  Type type = Type::kFloat;
  std::optional<Type> count;  // of a list
};

struct Element {
  std::string name;
  long count = 0;
  std::vector<Property> properties;
};

struct Header {
  enum class Format { kAscii, kLittleEndian, kBigEndian };
  Format format = Format::kAscii;
  std::vector<Element> elements;
  size_t end = 0;  // bytes before the data
  int lines = 0;
};

Type type_of(const MeshText& text, const std::string& word) {
  static const std::map<std::string, Type> kTypes{
      {"char", Type::kInt8},   {"int8", Type::kInt8},     {"uchar", Type::kUint8},   {"uint8", Type::kUint8},
      {"short", Type::kInt16}, {"int16", Type::kInt16},   {"ushort", Type::kUint16}, {"uint16", Type::kUint16},
      {"int", Type::kInt32},   {"int32", Type::kInt32},   {"uint", Type::kUint32},   {"uint32", Type::kUint32},
      {"float", Type::kFloat}, {"float32", Type::kFloat}, {"double", Type::kDouble}, {"float64", Type::kDouble}};
  const auto found = kTypes.find(word);
  if (found == kTypes.end()) text.refuse("types are char, uchar, short, ushort, int, uint, float and double");
  return found->second;
}

Property read_property(MeshText* text) {
  Property property;
  std::string word = text->word("a type");
  if (word == "list") {
    property.count = type_of(*text, text->word("the type of a number of items"));
    word = text->word("a type");
  }
  property.type = type_of(*text, word);
  property.name = text->word("the name of a property");
  return property;
}

void read_format(MeshText* text, Header* header) {
  const std::string word = text->word("a format");
  if (word == "binary_little_endian") {
    header->format = Header::Format::kLittleEndian;
  } else if (word == "binary_big_endian") {
    header->format = Header::Format::kBigEndian;
  } else if (word != "ascii") {
    text->refuse("formats are ascii, binary_little_endian and binary_big_endian");
  }
}

Header read_header(const std::string& bytes, const std::string& name) {
  constexpr size_t kLongest = 65536;
  const std::string mark = "end_header";
  Header header;
  const size_t at = bytes.substr(0, kLongest).find("\n" + mark);
  const size_t end = at == std::string::npos ? at : bytes.find('\n', at + 1);
  if (bytes.rfind("ply", 0) != 0 || end == std::string::npos) {
    throw InputError(name + ": no PLY file: its header goes from `ply` to `end_header`");
  }
  header.end = end + 1;
  MeshText text(name, bytes.substr(0, at + 1), 1, 0);
  while (!text.done()) {
    const std::string word = text.word("a statement");
    if (word == "format") read_format(&text, &header);
    if (word == "element") {
      Element element;
      element.name = text.word("the name of an element");
      element.count = text.integer("the number of elements", 0, static_cast<long>(Faces::kMostPoints));
      header.elements.push_back(element);
    } else if (word == "property") {
      if (header.elements.empty()) text.refuse("a property belongs to an element");
      header.elements.back().properties.push_back(read_property(&text));
    }
    text.skip_line();
  }
  for (const char c : bytes.substr(0, header.end)) header.lines += c == '\n';
  return header;
}

/// The values behind the header, one after the other.
class Values {
 public:
  virtual ~Values() = default;
  virtual double next(Type type) = 0;
  [[noreturn]] virtual void refuse(const std::string& what) const = 0;
};

class AsciiValues : public Values {
 public:
  AsciiValues(const std::string& name, std::string text, int first_line)
      : text_(name, std::move(text), first_line, 0) {}
  double next(Type) override { return text_.number("a value"); }
  [[noreturn]] void refuse(const std::string& what) const override { text_.refuse(what); }

 private:
  MeshText text_;
};

class BinaryValues : public Values {
 public:
  BinaryValues(std::string name, const std::string& bytes, size_t at, bool swapped)
      : name_(std::move(name)), bytes_(bytes), at_(at), swapped_(swapped) {}

  double next(Type type) override {
    switch (type) {
      case Type::kInt8:
        return take<std::int8_t>();
      case Type::kUint8:
        return take<std::uint8_t>();
      case Type::kInt16:
        return take<std::int16_t>();
      case Type::kUint16:
        return take<std::uint16_t>();
      case Type::kInt32:
        return take<std::int32_t>();
      case Type::kUint32:
        return take<std::uint32_t>();
      case Type::kFloat:
        return take<float>();
      case Type::kDouble:
        return take<double>();
    }
    return 0.0;
  }
  [[noreturn]] void refuse(const std::string& what) const override { throw InputError(name_ + ": " + what); }

 private:
  template <class T>
  double take() {
    if (bytes_.size() - at_ < sizeof(T)) refuse("ends before all that its header claims");
    char raw[sizeof(T)];
    for (size_t k = 0; k < sizeof(T); ++k) raw[swapped_ ? sizeof(T) - 1 - k : k] = bytes_[at_ + k];
    at_ += sizeof(T);
    T value;
    std::memcpy(&value, raw, sizeof(T));
    return static_cast<double>(value);
  }

  std::string name_;
  const std::string& bytes_;
  size_t at_;
  bool swapped_;
};

/// A number of items or of a vertex.
long whole(const Values& values, double number) {
  if (!(number >= 0.0 && number < 4294967296.0) || number != std::floor(number)) {
    values.refuse("numbers of corners and of vertices are whole and not negative");
  }
  return static_cast<long>(number);
}

float coordinate(const Values& values, double number) {
  const float value = static_cast<float>(std::isfinite(number) && std::abs(number) < 1e38 ? number : NAN);
  if (!std::isfinite(value)) values.refuse("a coordinate must be a finite number");
  return value;
}

void read_element(const Element& element, Values* values, Faces* faces) {
  const bool vertex = element.name == "vertex", face = element.name == "face";
  Faces::Point point{};
  for (const Property& property : element.properties) {
    if (!property.count) {
      const double value = values->next(property.type);
      if (!vertex) continue;
      const size_t axis = std::string("xyz").find(property.name);
      if (property.name.size() == 1 && axis != std::string::npos) point[axis] = coordinate(*values, value);
      continue;
    }
    const bool corners = face && (property.name == "vertex_indices" || property.name == "vertex_index");
    const long count = whole(*values, values->next(*property.count));
    for (long k = 0; k < count; ++k) {
      const double value = values->next(property.type);
      if (corners) faces->add_corner(whole(*values, value));
    }
    if (!corners) continue;
    if (count < 3) values->refuse("has a face with " + std::to_string(count) + " vertices; three are needed");
    faces->end_face();
  }
  if (vertex) faces->add_point(point);
}

}  // namespace

Faces read_ply(const std::string& bytes, const std::string& name) {
  const Header header = read_header(bytes, name);
  std::unique_ptr<Values> values;
  if (header.format == Header::Format::kAscii) {
    values = std::make_unique<AsciiValues>(name, bytes.substr(header.end), header.lines + 1);
  } else {
    values = std::make_unique<BinaryValues>(name, bytes, header.end, header.format == Header::Format::kBigEndian);
  }
  Faces faces;
  for (const Element& element : header.elements) {
    if (element.name == "tristrips") throw InputError(name + ": holds strips of triangles; save it with faces");
    if (element.properties.empty()) continue;
    for (long k = 0; k < element.count; ++k) read_element(element, values.get(), &faces);
  }
  faces.check();
  return faces;
}

}  // namespace deformable_sim
