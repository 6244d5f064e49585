// Reads config/solvers.yaml.
#include <fstream>
#include <iterator>

#include "deformable_sim/scene/load.h"
#include "deformable_sim/scene/solver_choice.h"
#include "schema.h"
#include "yaml_value.h"

namespace deformable_sim {
namespace {

const Range kShare = above(0, 1e3);

Table<SolverConfiguration> configuration_table() {
  using C = SolverConfiguration;
  Table<C> t("configurations[]", "One way to run a scene.");
  t.text("integrator", &C::integrator, "").required();
  t.text("linear_solver", &C::linear_solver, "");
  t.integer("newton_iterations", &C::newton_iterations, 0, 1000, "");
  t.number("linear_tolerance", "", &C::linear_tolerance, between(0, 1), "");
  t.integer("linear_iterations", &C::linear_iterations, 0, 100000, "");
  t.text("precision", &C::precision, "");
  t.number("fraction_of_limit", "", &C::fraction_of_limit, above(0, 0.95), "");
  t.number("dt", "s", &C::dt, between(kLeastStep, kLongestStep), "").required();
  return t;
}

size_t read_index(const YamlValue& v, const std::string& path, size_t count) {
  return static_cast<size_t>(read_integer(v, path, 0, static_cast<int>(count) - 1));
}

Table<SolverTable::Scene> scene_table(size_t count) {
  using S = SolverTable::Scene;
  const auto features = [](auto SceneFeatures::*member) {
    return [member](S & s) -> auto& {
      return s.features.*member;
    };
  };
  Table<S> t("scenes[]", "A measured scene.");
  t.text("name", &S::name, "").required();
  t.text("bodies", features(&SceneFeatures::bodies), "").required();
  t.integer("nodes", features(&SceneFeatures::nodes), 1, kMaxNodes, "").required();
  t.number("explicit_steps", "", features(&SceneFeatures::explicit_steps), above(0, 1e9), "").required();
  t.boolean("contact", features(&SceneFeatures::contact), "");
  t.boolean("strain_limits", features(&SceneFeatures::strain_limits), "");
  t.add({"runs", "list", "", "", "", "Configuration, error, CPU s per simulated s."},
        [count](const YamlValue& v, const std::string& path, S* out) {
          for (const YamlValue& item : read_list(v, path, "runs")) {
            if (item.items.size() != 3) refuse(item, path, "a run is [configuration, error, cpu]");
            out->runs.push_back({read_index(item.items[0], path, count), read_number(item.items[1], path, kShare),
                                 read_number(item.items[2], path, above(0, 1e9))});
          }
        });
  t.add({"failed", "list", "", "", "", "Configurations that diverged."},
        [count](const YamlValue& v, const std::string& path, S* out) {
          for (const YamlValue& item : read_list(v, path, "configurations")) {
            out->failed.push_back(read_index(item, path, count));
          }
        });
  t.add({"cheapest", "list", "", "", "", "Error, CPU s per simulated s."},
        [](const YamlValue& v, const std::string& path, S* out) {
          for (const YamlValue& item : read_list(v, path, "pairs")) {
            double pair[2];
            read_vector(item, path, above(0, 1e9), pair, 2);
            out->cheapest.push_back({pair[0], pair[1]});
          }
        });
  return t;
}

}  // namespace

std::string solver_table_file() {
  return package_dir() + "/config/solvers.yaml";
}

SolverTable read_solver_table(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw InputError(file + ": cannot be read; choose step.integrator by hand", Code::kNotFound);
  const std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  const YamlValue root = parse_yaml(text, file);
  SolverTable table;
  Table<SolverTable> t("", "Measured errors and costs.");
  t.add({"configurations", "list", "", "", "", ""}, [](const YamlValue& v, const std::string& path, SolverTable* out) {
     for (const YamlValue& item : read_list(v, path, "configurations")) {
       out->configurations.emplace_back();
       configuration_table().read(item, path, &out->configurations.back());
     }
   }).required();
  t.add({"scenes", "list", "", "", "", ""}, [](const YamlValue& v, const std::string& path, SolverTable* out) {
     const Table<SolverTable::Scene> scenes = scene_table(out->configurations.size());
     for (const YamlValue& item : read_list(v, path, "scenes")) {
       out->scenes.emplace_back();
       scenes.read(item, path, &out->scenes.back());
     }
   }).required();
  t.read(root, "", &table);
  return table;
}

}  // namespace deformable_sim
