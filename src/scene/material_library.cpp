#include "deformable_sim/scene/material_library.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>
#include <sstream>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/material/solid_law.h"
#include "deformable_sim/scene/load.h"
#include "schema.h"
#include "yaml_value.h"

namespace deformable_sim {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// An entry of ropes.yaml as it stands there.
struct RopeText {
  MaterialOrigin origin;
  double specific_gravity = 1.0;   // 1000 kg/m^3
  double specific_modulus = 1.0;   // N/tex
  double specific_strength = 1.0;  // N/tex
  double linear_density = 0.0;     // kg/m
  double fill = 1.0;
  double construction = 1.0;
  double filament = 0.0;  // m
  double poissons_ratio = 0.3;
  std::string solid;
  double diameter = 0.0;  // m
};

/// An entry of fabrics.yaml: orthotropic, or isotropic with a thickness.
struct FabricText {
  FabricData data;
  std::optional<double> youngs_modulus, poissons_ratio, thickness, bend_diagonal;
};

template <class T>
Table<T> described(const std::string& table, const std::string& doc) {
  Table<T> t(table, doc);
  const auto origin = [](T& x) -> MaterialOrigin& {
    if constexpr (std::is_same_v<T, FabricText>) {
      return x.data.origin;
    } else {
      return x.origin;
    }
  };
  t.name(
      "name", [origin](T& x) -> std::string& { return origin(x).name; }, "of the material");
  t.text(
       "title", [origin](T& x) -> std::string& { return origin(x).title; }, "in words")
      .required();
  t.text(
       "source", [origin](T& x) -> std::string& { return origin(x).source; }, "of the numbers")
      .required();
  t.add({"estimated", "list", "", "", "", "keys whose value no test gives"},
        [origin](const YamlValue& v, const std::string& path, T* out) {
          for (const YamlValue& item : read_list(v, path, "keys")) {
            origin(*out).estimated.push_back(read_text(item, path));
          }
        });
  return t;
}

Table<SolidData> solid_table() {
  Table<SolidData> t = described<SolidData>("solids", "isotropic solids");
  t.number("youngs_modulus", "Pa", &SolidData::youngs_modulus, above(0, 1e13), "E").required();
  t.add({"youngs_modulus_range", "[low, high]", "Pa", "", "> 0", "over grades, directions and batches", true},
        [](const YamlValue& v, const std::string& path, SolidData* out) {
          std::array<double, 2> range{};
          read_vector(v, path, above(0, 1e13), range.data(), 2);
          out->youngs_modulus_low = range[0];
          out->youngs_modulus_high = range[1];
        });
  t.number("poissons_ratio", "", &SolidData::poissons_ratio, between(-0.99, 0.4999), "nu").required();
  t.number("density", "kg/m^3", &SolidData::density, above(0, 3e4), "").required();
  t.number("elastic_limit", "", &SolidData::elastic_limit, above(0, 20), "strain").required();
  t.choice("limit_kind", &SolidData::limit_kind, {"yield", "fracture", "linear_range"}, "what happens there")
      .required();
  t.choice("law", &SolidData::law, solid_law_names(), "the stress-strain law that suits it");
  return t;
}

Table<FabricText> fabric_table() {
  Table<FabricText> t = described<FabricText>("fabrics", "fabrics, films and paper");
  const Range stiff = above(0, 1e8), bend = above(0, 10);
  t.number(
      "areal_density", "kg/m^2", [](FabricText& f) -> double& { return f.data.areal_density; }, above(0, 100), "");
  t.required();
  t.optional_number("thickness", "m", &FabricText::thickness, above(0, 0.1), "unknown", "");
  t.number(
      "warp", "N/m", [](FabricText& f) -> double& { return f.data.warp; }, stiff, "c11");
  t.number(
      "weft", "N/m", [](FabricText& f) -> double& { return f.data.weft; }, stiff, "c22");
  t.number(
      "poisson", "N/m", [](FabricText& f) -> double& { return f.data.poisson; }, between(-1e8, 1e8), "c12");
  t.number(
      "shear", "N/m", [](FabricText& f) -> double& { return f.data.shear; }, stiff, "c33");
  t.optional_number("youngs_modulus", "Pa", &FabricText::youngs_modulus, above(0, 1e13), "none", "isotropic E");
  t.optional_number("poissons_ratio", "", &FabricText::poissons_ratio, between(0, 0.5), "none", "isotropic nu");
  t.number(
       "bend_warp", "N m", [](FabricText& f) -> double& { return f.data.bend_warp; }, bend, "")
      .required();
  t.number(
       "bend_weft", "N m", [](FabricText& f) -> double& { return f.data.bend_weft; }, bend, "")
      .required();
  t.optional_number("bend_diagonal", "N m", &FabricText::bend_diagonal, bend, "unknown", "");
  t.number(
       "limit", "", [](FabricText& f) -> double& { return f.data.limit; }, above(0, 2), "strain")
      .required();
  return t;
}

Table<RopeText> rope_text_table() {
  Table<RopeText> t = described<RopeText>("ropes", "yarns, ropes, cables and wires");
  t.number("specific_gravity", "", &RopeText::specific_gravity, above(0, 30), "");
  t.number("specific_modulus", "N/tex", &RopeText::specific_modulus, above(0, 1000), "");
  t.number("specific_strength", "N/tex", &RopeText::specific_strength, above(0, 100), "");
  t.number("linear_density", "kg/m", &RopeText::linear_density, above(0, 100), "");
  t.number("fill", "", &RopeText::fill, above(0, 1), "");
  t.number("construction", "", &RopeText::construction, above(0, 1), "");
  t.number("filament", "m", &RopeText::filament, above(0, 0.1), "");
  t.number("poissons_ratio", "", &RopeText::poissons_ratio, between(0, 0.5), "");
  t.text("solid", &RopeText::solid, "");
  t.number("diameter", "m", &RopeText::diameter, above(0, 0.5), "");
  return t;
}

FabricData fabric_of(const FabricText& text, const YamlValue& where, const std::string& path) {
  FabricData f = text.data;
  f.thickness = text.thickness;
  f.bend_diagonal = text.bend_diagonal;
  if (text.youngs_modulus || text.poissons_ratio) {
    if (!text.youngs_modulus || !text.poissons_ratio || !text.thickness || f.warp != 0.0) {
      refuse(where, path, "an isotropic sheet needs youngs_modulus, poissons_ratio and thickness, and no warp");
    }
    const double eh = *text.youngs_modulus * *text.thickness, nu = *text.poissons_ratio;
    f.warp = f.weft = eh / (1.0 - nu * nu);
    f.poisson = nu * f.warp;
    f.shear = eh / (2.0 * (1.0 + nu));
  } else if (f.warp == 0.0 || f.weft == 0.0 || f.shear == 0.0) {
    refuse(where, path, "needs warp, weft and shear, or youngs_modulus, poissons_ratio and thickness");
  }
  return f;
}

RopeData wire_of(const RopeText& text, const SolidData& solid) {
  RopeData r;
  r.origin = text.origin;
  r.diameter = text.diameter;
  const double area = 0.25 * kPi * r.diameter * r.diameter, square = r.diameter * r.diameter;
  r.linear_density = solid.density * area;
  r.axial = solid.youngs_modulus * area;
  r.bending = r.axial * square / 16.0;
  r.twist = solid.shear_modulus() * area * square / 8.0;
  r.breaking_strain = solid.elastic_limit;
  r.specific_modulus = solid.youngs_modulus / solid.density;
  return r;
}

RopeData rope_of(const RopeText& text, const YamlValue& where, const std::string& path,
                 const std::vector<SolidData>& solids) {
  if (!text.solid.empty()) {
    const auto found =
        std::find_if(solids.begin(), solids.end(), [&](const SolidData& s) { return s.origin.name == text.solid; });
    if (found == solids.end()) refuse(where, path + ".solid", "no solid '" + text.solid + "'", Code::kNotFound);
    if (text.diameter == 0.0) refuse(where, path, "a wire needs its diameter");
    return wire_of(text, *found);
  }
  if (text.linear_density == 0.0 || text.filament == 0.0 || text.diameter != 0.0) {
    refuse(where, path, "needs linear_density and filament, or solid and diameter");
  }
  RopeData r;
  r.origin = text.origin;
  r.linear_density = text.linear_density;
  r.construction = text.construction;
  r.specific_modulus = 1e6 * text.specific_modulus;
  r.axial = r.construction * r.specific_modulus * r.linear_density;
  r.diameter = std::sqrt(4.0 * r.linear_density / (kPi * 1000.0 * text.specific_gravity * text.fill));
  r.bending = r.axial * text.filament * text.filament / 16.0;
  r.twist = r.bending / (1.0 + text.poissons_ratio);
  r.breaking_strain = text.specific_strength / text.specific_modulus;
  return r;
}

YamlValue read_file(const std::string& file) {
  std::ifstream stream(file);
  if (!stream) throw InputError("cannot read " + file, Code::kNotFound);
  std::ostringstream text;
  text << stream.rdbuf();
  return parse_yaml(text.str(), file);
}

/// Calls `read` for every entry of the list `materials`.
template <class Read>
void for_each_entry(const std::string& file, Read read) {
  const YamlValue root = read_file(file);
  const YamlValue* list = root.find("materials");
  if (list == nullptr) refuse(root, "materials", "required, and missing");
  const std::vector<YamlValue>& entries = read_list(*list, "materials", "maps");
  for (size_t k = 0; k < entries.size(); ++k) read(entries[k], "materials[" + std::to_string(k) + "]");
}

template <class T>
const T* among(const std::vector<T>& entries, const std::string& name) {
  for (const T& entry : entries) {
    if (entry.origin.name == name) return &entry;
  }
  return nullptr;
}

template <class T>
std::vector<std::string> names_of(const std::vector<T>& entries) {
  std::vector<std::string> names;
  for (const T& entry : entries) names.push_back(entry.origin.name);
  return names;
}

[[noreturn]] void refuse_name(const MaterialLibrary& library, const std::string& name, const std::string& kind,
                              const std::vector<std::string>& of_kind) {
  const char* other = among(library.solids, name) ? "solid" : among(library.fabrics, name) ? "fabric" : "rope";
  const std::vector<std::string> all = library.names();
  const std::string why = std::find(all.begin(), all.end(), name) != all.end()
                              ? "'" + name + "' is a " + other + ", not a " + kind
                              : "no " + kind + " '" + name + "'";
  const std::vector<std::string> near = nearest_words(name, of_kind, 4);
  throw InputError(why + "; " + (near.empty() ? "there is " + join(of_kind) : "did you mean " + join(near) + "?"),
                   Code::kNotFound);
}

}  // namespace

const SolidData& MaterialLibrary::solid(const std::string& name) const {
  const SolidData* found = among(solids, name);
  if (!found) refuse_name(*this, name, "solid", names_of(solids));
  return *found;
}

const FabricData& MaterialLibrary::fabric(const std::string& name) const {
  const FabricData* found = among(fabrics, name);
  if (!found) refuse_name(*this, name, "fabric", names_of(fabrics));
  return *found;
}

const RopeData& MaterialLibrary::rope(const std::string& name) const {
  const RopeData* found = among(ropes, name);
  if (!found) refuse_name(*this, name, "rope", names_of(ropes));
  return *found;
}

std::variant<SolidData, FabricData, RopeData> MaterialLibrary::find(const std::string& name) const {
  if (const SolidData* s = among(solids, name)) return *s;
  if (const FabricData* f = among(fabrics, name)) return *f;
  if (const RopeData* r = among(ropes, name)) return *r;
  refuse_name(*this, name, "material", names());
}

std::vector<std::string> MaterialLibrary::names() const {
  std::vector<std::string> all = names_of(solids);
  for (const auto& more : {names_of(fabrics), names_of(ropes)}) all.insert(all.end(), more.begin(), more.end());
  return all;
}

MaterialLibrary load_material_library(const std::string& folder) {
  MaterialLibrary library;
  std::set<std::string> seen;
  const auto once = [&seen](const YamlValue& entry, const std::string& path, const std::string& name) {
    if (!seen.insert(name).second) refuse(entry, path + ".name", "'" + name + "' is taken", Code::kAlreadyExists);
  };
  const Table<SolidData> solids = solid_table();
  for_each_entry(folder + "/solids.yaml", [&](const YamlValue& entry, const std::string& path) {
    SolidData solid;
    solids.read(entry, path, &solid);
    once(entry, path, solid.origin.name);
    library.solids.push_back(solid);
  });
  const Table<FabricText> fabrics = fabric_table();
  for_each_entry(folder + "/fabrics.yaml", [&](const YamlValue& entry, const std::string& path) {
    FabricText text;
    fabrics.read(entry, path, &text);
    once(entry, path, text.data.origin.name);
    library.fabrics.push_back(fabric_of(text, entry, path));
  });
  const Table<RopeText> ropes = rope_text_table();
  for_each_entry(folder + "/ropes.yaml", [&](const YamlValue& entry, const std::string& path) {
    RopeText text;
    ropes.read(entry, path, &text);
    once(entry, path, text.origin.name);
    library.ropes.push_back(rope_of(text, entry, path, library.solids));
  });
  return library;
}

std::string default_material_dir() {
  return package_dir() + "/config/materials";
}

}  // namespace deformable_sim
