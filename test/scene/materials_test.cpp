// The tables of real materials: they load, are physical, agree with what they were taken from, and are documented.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "deformable_sim/core/error.h"
#include "deformable_sim/core/material/solid_law.h"
#include "deformable_sim/scene/material_library.h"

namespace deformable_sim {
namespace {

const std::string kSource = DEFORMABLE_SIM_SOURCE_DIR;

const MaterialLibrary& library() {
  static const MaterialLibrary loaded = load_material_library(kSource + "/config/materials");
  return loaded;
}

std::string read(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

/// Rows of a CSV table without its heading; quoted cells may hold commas.
std::vector<std::vector<std::string>> csv(const std::string& name) {
  std::istringstream lines(read(kSource + "/test/verify/data/" + name));
  std::vector<std::vector<std::string>> rows;
  std::string line;
  std::getline(lines, line);
  while (std::getline(lines, line)) {
    std::vector<std::string> cells(1);
    bool quoted = false;
    for (const char c : line) {
      if (c == '"')
        quoted = !quoted;
      else if (c == ',' && !quoted)
        cells.emplace_back();
      else if (c != '\r')
        cells.back() += c;
    }
    rows.push_back(cells);
  }
  EXPECT_FALSE(rows.empty()) << name;
  return rows;
}

double number(const std::string& text) {
  return std::stod(text);
}

/// The name of an entry for a row's label: lower case, other characters replaced by one underscore.
std::string name_of(const std::string& label) {
  std::string name;
  for (const char c : label)
    name += std::isalnum(static_cast<unsigned char>(c)) ? static_cast<char>(std::tolower(c)) : '_';
  return name;
}

bool estimated(const MaterialOrigin& origin, const std::string& key) {
  return std::find(origin.estimated.begin(), origin.estimated.end(), key) != origin.estimated.end();
}

TEST(MaterialTables, HoldSolidsFromRubberToDiamondInTheOrderOfStiffness) {
  // 10 kPa ... 1.22 TPa, each value within the range it names; E = 9 K G / (3 K + G).
  ASSERT_GE(library().solids.size(), 40u);
  double before = 0.0;
  for (const SolidData& s : library().solids) {
    SCOPED_TRACE(s.origin.name);
    EXPECT_GE(s.youngs_modulus, before);
    before = s.youngs_modulus;
    EXPECT_LE(s.youngs_modulus_low, s.youngs_modulus);
    EXPECT_GE(s.youngs_modulus_high, s.youngs_modulus);
    EXPECT_GE(s.poissons_ratio, 0.0);
    EXPECT_LT(s.poissons_ratio, 0.5);
    EXPECT_GT(s.density, 10.0);
    EXPECT_LT(s.density, 23000.0);
    const double g = s.shear_modulus(), k = s.bulk_modulus();
    EXPECT_NEAR(9.0 * k * g / (3.0 * k + g), s.youngs_modulus, 1e-9 * s.youngs_modulus);
    EXPECT_NO_THROW(solid_material(solid_law(s.law), s.youngs_modulus, s.poissons_ratio));
    // Sound is slower than in diamond, faster than in gelatin.
    EXPECT_LT(std::sqrt(s.youngs_modulus / s.density), 19000.0);
    EXPECT_GT(std::sqrt(s.youngs_modulus / s.density), 3.0);
  }
  EXPECT_EQ(library().solids.back().origin.name, "diamond");
  EXPECT_DOUBLE_EQ(library().solid("steel").youngs_modulus, 2.0e11);
}

TEST(MaterialTables, HoldFabricsThatGainNoEnergyByBeingPulled) {
  // Plane stiffness positive definite: warp weft > poisson^2, shear > 0; bending lengths of cloth are 5 ... 60 mm.
  ASSERT_GE(library().fabrics.size(), 28u);
  for (const FabricData& f : library().fabrics) {
    SCOPED_TRACE(f.origin.name);
    EXPECT_GT(f.warp * f.weft, f.stable_poisson() * f.stable_poisson());
    EXPECT_GT(f.shear, 0.0);
    EXPECT_GT(f.traction_warp(), 0.0);
    EXPECT_GT(f.traction_bias(), 0.0);
    EXPECT_GT(f.areal_density, 0.01);
    EXPECT_LT(f.areal_density, 0.6);
    EXPECT_GT(f.bending_length(), 0.005);
    EXPECT_LT(f.bending_length(), f.origin.name == "paper" ? 0.2 : 0.06);
    EXPECT_LE(f.limit, 0.7);
    if (f.bend_twist()) {
      EXPECT_NEAR(1.0 / f.bend_warp + 1.0 / f.bend_weft + 1.0 / *f.bend_twist(), 4.0 / *f.bend_diagonal, 1e-3);
      EXPECT_GT(*f.bend_twist(), 0.0);
    }
    if (f.thickness) {
      EXPECT_GT(*f.thickness, 5e-5);
      EXPECT_LT(*f.thickness, 3e-3);
    }
  }
}

TEST(MaterialTables, HoldRopesWhoseWaveSpeedIsTheFibres) {
  // sqrt(EA / linear density) = sqrt(construction E / rho), whatever the size.
  ASSERT_GE(library().ropes.size(), 20u);
  for (const RopeData& r : library().ropes) {
    SCOPED_TRACE(r.origin.name);
    EXPECT_NEAR(r.wave_speed(), std::sqrt(r.construction * r.specific_modulus), 1e-9 * r.wave_speed());
    EXPECT_GT(r.diameter, 1e-5);
    EXPECT_LT(r.diameter, 0.05);
    // No rope is stiffer in bending than a solid rod of its diameter.
    EXPECT_LE(r.bending, r.axial * r.diameter * r.diameter / 16.0 * 1.01);
    EXPECT_GT(r.twist, 0.0);
    EXPECT_LE(r.twist, r.bending * (1.0 + 1e-12));
    EXPECT_GT(r.breaking_strain, 0.0);
  }
  const double d = 1e-3, area = 0.25 * 3.14159265358979 * d * d;
  EXPECT_NEAR(library().rope("steel_wire_1mm").axial, 2e11 * area, 1e-6 * 2e11 * area);
  EXPECT_NEAR(library().rope("steel_wire_1mm").bending, 2e11 * area * d * d / 16.0, 1e-6);
}

TEST(MaterialTables, EqualTheTesterOfTenFabrics) {
  for (const auto& row : csv("C7a_textiles_wang2011.csv")) {
    const FabricData& f = library().fabric(row[0] == "11oz-black-denim" ? "denim_11oz_black" : name_of(row[0]));
    EXPECT_DOUBLE_EQ(f.areal_density, number(row[3]));
    EXPECT_DOUBLE_EQ(f.warp, number(row[4]));
    EXPECT_DOUBLE_EQ(f.weft, number(row[5]));
    EXPECT_DOUBLE_EQ(f.poisson, number(row[6]));
    EXPECT_DOUBLE_EQ(f.shear, number(row[7]));
    EXPECT_DOUBLE_EQ(f.bend_warp, number(row[8]));
    EXPECT_DOUBLE_EQ(f.bend_weft, number(row[9]));
    EXPECT_DOUBLE_EQ(f.bend_diagonal.value_or(0.0), number(row[10]));
    EXPECT_NEAR(1e3 * f.bending_length(), number(row[11]), 1e-2 * number(row[11]));
  }
}

TEST(MaterialTables, EqualTheIsotropicFits) {
  // E h and nu as tabulated; the traction stiffness of a strip is E h again.
  const std::map<std::string, std::string> names = {{"100% cotton", "cotton_penava"},
                                                    {"100% wool", "wool_penava"},
                                                    {"95% wool 5% lycra", "wool_lycra_penava"},
                                                    {"100% polyester", "polyester_penava"},
                                                    {"paper-like", "paper"}};
  for (const auto& row : csv("C7b_textiles_penava2014_cipc.csv")) {
    const FabricData& f = library().fabric(names.at(row[0]));
    EXPECT_DOUBLE_EQ(f.thickness.value_or(0.0), number(row[1]));
    EXPECT_NEAR(f.areal_density / *f.thickness, number(row[2]), 1e-3 * number(row[2]));
    EXPECT_NEAR(f.traction_warp(), number(row[7]), 1e-5 * number(row[7]));
    EXPECT_NEAR(f.traction_bias(), number(row[7]), 1e-5 * number(row[7]));
    EXPECT_NEAR(f.poisson / f.warp, number(row[4]), 1e-12);
    EXPECT_NEAR(f.limit, number(row[5]) - 1.0, 1e-12);
    EXPECT_NEAR(f.areal_density, number(row[6]), 1e-12);
    if (row[0] == "paper-like") {
      EXPECT_DOUBLE_EQ(f.bend_warp, number(row[8]));
    } else {
      EXPECT_GT(f.bend_warp, 2.0 * number(row[8])) << "measured bending is far above E h^3 / 12";
      EXPECT_TRUE(estimated(f.origin, "bend_warp"));
    }
  }
}

TEST(MaterialTables, EqualTheOrthotropicFitsTimesThickness) {
  for (const auto& row : csv("C7c_textiles_clyde2017_cipc.csv")) {
    const FabricData& f = library().fabric(row[0] + "_clyde");
    const double h = number(row[2]);
    EXPECT_NEAR(f.areal_density, 1e-3 * number(row[1]), 1e-12);
    EXPECT_DOUBLE_EQ(f.thickness.value_or(0.0), h);
    EXPECT_NEAR(f.warp, h * number(row[4]), 1e-6 * f.warp);
    EXPECT_NEAR(f.poisson, h * number(row[5]), 1e-6 * f.warp);
    EXPECT_NEAR(f.weft, h * number(row[6]), 1e-6 * f.weft);
    EXPECT_NEAR(f.shear, h * number(row[7]), 1e-6 * f.shear);
    EXPECT_DOUBLE_EQ(f.limit, std::min(number(row[8]), number(row[9])));
  }
}

TEST(MaterialTables, EqualThePercentilesOf618Fabrics) {
  const auto rows = csv("C7d_bending_618_fabrics_percentiles.csv");
  const std::map<std::string, size_t> columns = {
      {"fabric_p5", 2}, {"fabric_p25", 3}, {"fabric_median", 4}, {"fabric_p75", 5}, {"fabric_p95", 6}};
  for (const auto& [name, column] : columns) {
    const FabricData& f = library().fabric(name);
    EXPECT_DOUBLE_EQ(f.areal_density, number(rows[0][column]));
    EXPECT_DOUBLE_EQ(f.bend_warp, number(rows[1][column]));
    EXPECT_DOUBLE_EQ(f.bend_weft, number(rows[2][column]));
    EXPECT_DOUBLE_EQ(f.bend_diagonal.value_or(0.0), number(rows[3][column]));
  }
}

TEST(MaterialTables, EqualTheSwatches) {
  for (const auto& row : csv("C7e_textiles_swatch_tests.csv")) {
    const FabricData& f = library().fabric(name_of(row[0]));
    EXPECT_DOUBLE_EQ(f.areal_density, number(row[1]));
    EXPECT_DOUBLE_EQ(f.warp, number(row[2]));
    EXPECT_DOUBLE_EQ(f.weft, number(row[3]));
    if (row[4].empty()) {
      EXPECT_TRUE(estimated(f.origin, "bend_warp"));
    } else {
      EXPECT_DOUBLE_EQ(f.bend_warp, number(row[4]));
    }
    EXPECT_DOUBLE_EQ(f.bend_weft, number(row[5]));
  }
}

TEST(MaterialTables, EqualTheFibreTable) {
  // 1 N/tex = 1e6 m^2/s^2; a yarn keeps all of its modulus, a rope of 0.05 kg/m 0.4 of it.
  const std::vector<std::string> names = {"nylon",     "polyester", "polypropylene", "kevlar_29",
                                          "kevlar_49", "hmpe",      "vectran"};
  const auto rows = csv("B18_rope_yarn_properties.csv");
  ASSERT_EQ(rows.size(), names.size() + 1);
  for (size_t k = 0; k < rows.size(); ++k) {
    const bool steel = k == names.size();
    const RopeData& yarn = library().rope(steel ? "steel_fine_wire" : names[k] + "_yarn");
    const RopeData& rope = library().rope(steel ? "steel_cable" : names[k] + "_rope");
    EXPECT_DOUBLE_EQ(yarn.specific_modulus, 1e6 * number(rows[k][2]));
    EXPECT_NEAR(yarn.breaking_strain, number(rows[k][3]) / number(rows[k][2]), 1e-12);
    EXPECT_NEAR(yarn.wave_speed(), number(rows[k][4]), 1.0);
    EXPECT_DOUBLE_EQ(rope.linear_density, 0.05);
    EXPECT_NEAR(rope.axial / rope.construction, 1e3 * number(rows[k][5]), 1e-9 * rope.axial);
  }
}

TEST(MaterialLibraryFind, NamesTheNearestAndTheRightKind) {
  const auto message = [](auto call) -> std::string {
    try {
      call();
    } catch (const InputError& error) {
      EXPECT_EQ(error.code(), Code::kNotFound);
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(message([] { library().fabric("coton_voile"); }), "no fabric 'coton_voile'; did you mean cotton_voile?");
  EXPECT_NE(message([] { library().fabric("cotton"); }).find("did you mean cotton_penava, cotton_clyde, cotton_voile?"),
            std::string::npos);
  EXPECT_EQ(message([] { library().rope("steel"); }),
            "'steel' is a solid, not a rope; did you mean steel_fine_wire, steel_cable, steel_wire_1mm?");
  EXPECT_NE(message([] { library().find("xyzzy"); }).find("there is gelatin, "), std::string::npos);
  EXPECT_TRUE(std::holds_alternative<RopeData>(library().find("hmpe_rope")));
  EXPECT_EQ(library().names().size(), library().solids.size() + library().fabrics.size() + library().ropes.size());
}

/// The message of the refusal of a table, with one file replaced.
std::string refusal(const std::string& file, const std::string& text) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / ("materials_test_" + std::to_string(::getpid()));
  fs::remove_all(folder);
  fs::copy(kSource + "/config/materials", folder);
  std::ofstream(folder / file) << text;
  std::string message = "accepted";
  try {
    load_material_library(folder.string());
  } catch (const InputError& error) {
    message = error.what();
  }
  fs::remove_all(folder);
  return message;
}

TEST(MaterialTables, RefuseWhatIsNotPhysicalByLine) {
  const std::string solid =
      "materials:\n  - {name: a, title: a, source: s, youngs_modulus: 1e6, "
      "youngs_modulus_range: [1e6, 1e6], density: 1000, elastic_limit: 0.1, limit_kind: yield, ";
  EXPECT_NE(refusal("solids.yaml", solid + "poissons_ratio: 0.5}\n")
                .find("solids.yaml:2: materials[0].poissons_ratio: 0.5 "
                      "is out of range"),
            std::string::npos);
  EXPECT_NE(refusal("solids.yaml", solid + "poissons_ratio: 0.3, law: jelly}\n").find("unknown 'jelly'"),
            std::string::npos);
  EXPECT_NE(refusal("solids.yaml", solid + "poissons_ratio: 0.3, hardness: 3}\n").find("unknown key"),
            std::string::npos);
  EXPECT_NE(refusal("fabrics.yaml",
                    "materials:\n  - {name: a, title: a, source: s, areal_density: 0.1, warp: 100, bend_warp: 1e-5, "
                    "bend_weft: 1e-5, limit: 0.1}\n")
                .find("needs warp, weft and shear"),
            std::string::npos);
  EXPECT_NE(
      refusal("fabrics.yaml",
              "materials:\n  - {name: steel, title: a, source: s, areal_density: 0.1, warp: 100, weft: 100, shear: 10, "
              "bend_warp: 1e-5, bend_weft: 1e-5, limit: 0.1}\n")
          .find("'steel' is taken"),
      std::string::npos);
  EXPECT_NE(refusal("ropes.yaml", "materials:\n  - {name: a, title: a, source: s, solid: mithril, diameter: 0.001}\n")
                .find("no solid 'mithril'"),
            std::string::npos);
}

TEST(MaterialReference, IsCurrent) {
  EXPECT_TRUE(read(kSource + "/doc/materials.md") == material_reference(library()))
      << "regenerate: study --material-reference > doc/materials.md";
}

}  // namespace
}  // namespace deformable_sim
