#include "keys.h"

#include <algorithm>
#include <cctype>

namespace deformable_sim {
namespace {

const Range kCoordinate = between(-1000, 1000);
const Range kAnyNumber = between(-1e12, 1e12);
const Range kFriction = between(0, 10);
const Range kRate = between(0, 1000);

void read_rotation(const YamlValue& v, const std::string& path, PoseSpec* pose) {
  double a[3];
  read_vector(v, path, between(-100, 100), a, 3);
  pose->orientation = Eigen::AngleAxisd(a[2], Vec3::UnitZ()) * Eigen::AngleAxisd(a[1], Vec3::UnitY()) *
                      Eigen::AngleAxisd(a[0], Vec3::UnitX());
}

void read_quaternion(const YamlValue& v, const std::string& path, PoseSpec* pose) {
  Eigen::Vector4d q;
  read_vector(v, path, between(-1.01, 1.01), q.data(), 4);
  if (std::abs(q.norm() - 1.0) > 1e-3) {
    refuse(v, path, "has length " + format_number(q.norm()) + "; a unit quaternion [x, y, z, w] is allowed");
  }
  pose->orientation = Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized();
}

std::vector<std::string> read_names(const YamlValue& v, const std::string& path, const std::string& of_what) {
  std::vector<std::string> names;
  for (const YamlValue& item : read_list(v, path, of_what))
    names.push_back(read_text(item, path + "[" + std::to_string(names.size()) + "]"));
  return names;
}

}  // namespace

void check_bodies(const YamlValue& list, const std::string& path, const SceneSpec& scene) {
  std::vector<std::string> known;
  for (const BodySpec& body : scene.bodies) known.push_back(body.name);
  for (size_t k = 0; k < list.items.size(); ++k) {
    const YamlValue& item = list.items[k];
    if (std::find(known.begin(), known.end(), item.text) == known.end())
      refuse(item, path + "[" + std::to_string(k) + "]", "no body '" + item.text + "'; there is " + join(known),
             Code::kNotFound);
  }
}

Table<PoseSpec> pose_table() {
  Table<PoseSpec> t("pose", "Rigid placement in the world (of a body, a collider, a selection or a grasp).");
  t.vector("position", "[x, y, z]", "m", &PoseSpec::position, kCoordinate, "Origin.");
  t.add({"rpy", "[roll, pitch, yaw]", "rad", "[0, 0, 0]", "-100 ... 100",
         "Rotation about the fixed axes x, y, z, in this order."},
        read_rotation);
  t.add({"orientation", "[x, y, z, w]", "", "[0, 0, 0, 1]", "unit length", "The same as a quaternion."},
        read_quaternion);
  t.at_most_one_of({"rpy", "orientation"});
  return t;
}

Table<AirSpec> air_table() {
  Table<AirSpec> t("air",
                   "Air around the bodies. Without drag_coefficient and damping there is no aerodynamic force at all.");
  t.number("density", "kg/m^3", &AirSpec::density, between(0, 2000), "Of the air (or water: 1000).");
  t.number(
      "drag_coefficient", "", &AirSpec::drag_coefficient, between(0, 10),
      "Of a flat plate in normal flow (cloth), of a cylinder in cross flow (rope), of the frontal area (soft); 0 = "
      "none.");
  t.vector("wind", "[x, y, z]", "m/s", &AirSpec::wind, between(-100, 100), "Mean wind; acts through the drag.");
  t.number("gust_amplitude", "", &AirSpec::gust_amplitude, between(0, 1),
           "The wind is scaled by 1 + gust_amplitude sin(2 pi gust_frequency time).");
  t.number("gust_frequency", "Hz", &AirSpec::gust_frequency, between(0, 100), "See gust_amplitude.");
  t.number("damping", "1/s", &AirSpec::damping, between(0, 1000),
           "Linear drag per unit mass, the same for every node.");
  return t;
}

double read_accuracy(const YamlValue& v, const std::string& path) {
  const std::vector<std::pair<std::string, double>> words{
      {"interactive", 0.03}, {"engineering", 0.01}, {"reference", 0.001}};
  for (const auto& [word, error] : words) {
    if (v.kind == YamlValue::Kind::kScalar && v.text == word) return error;
  }
  const Range range = between(1e-5, 0.1);
  if (v.kind == YamlValue::Kind::kScalar && !v.quoted && !v.text.empty() &&
      std::isalpha(static_cast<unsigned char>(v.text[0])) == 0) {
    return read_number(v, path, range);
  }
  refuse(v, path, "must be interactive, engineering, reference or a number, " + range.text());
}

Table<StepSpec> step_table() {
  Table<StepSpec> t("step",
                    "Time stepping. Without any key but dt, accuracy and budget, the cheapest solver that is accurate "
                    "enough is chosen (auto). Keys from linear_solver on are for implicit schemes; line_dual, xpbd and "
                    "projective_dynamics "
                    "read newton_iterations (sweeps) and tolerance.");
  t.add({"solver", "word", "", "auto unless a key below names a part of it", "auto, manual",
         "auto: from what was measured of scenes like this one (config/solvers.yaml); describe says what and why. "
         "manual: as the keys below say, or their defaults."},
        [](const YamlValue& v, const std::string& path, StepSpec* out) {
          out->mode = read_choice(v, path, {"auto", "manual"}) == "auto" ? SolverMode::kAuto : SolverMode::kManual;
        });
  t.add(
      {"accuracy", "word or number", "", "engineering", "interactive, engineering, reference, 1e-5 ... 0.1",
       "With auto, or a control: error of the positions over a second (RMS, relative to the body's size): 3, 1 and 0.1 "
       "%."},
      [](const YamlValue& v, const std::string& path, StepSpec* out) { out->error = read_accuracy(v, path); });
  t.number("budget", "s/s", &StepSpec::budget, above(0, 1e6),
           "With auto, or control: budget: CPU time per simulated time that it may take; beyond, accuracy gives way.");
  t.number("accuracy_floor", "", &StepSpec::floor, between(1e-5, 1),
           "With control: budget: error of the positions over a second up to which accuracy gives way to the budget.");
  t.add(
      {"control", "word", "", "fixed", "fixed, error, budget",
       "Of the parts that a step of dt is made in. error: as many, up to 64, as hold the accuracy, estimated by making "
       "every eighth step twice; the same on every run. budget: no more than the budget allows, measured as it runs. "
       "~status warns of what is not held, and by how much."},
      [](const YamlValue& v, const std::string& path, StepSpec* out) {
        const std::string word = read_choice(v, path, {"fixed", "error", "budget"});
        out->control = word == "error"    ? StepControl::kError
                       : word == "budget" ? StepControl::kBudget
                                          : StepControl::kFixed;
      });
  t.add({"dt", "number", "s", "chosen (auto), 0.01 (manual)", between(kLeastStep, kLongestStep).text(),
         "One step of simulated time. auto divides one that is too long."},
        [](const YamlValue& v, const std::string& path, StepSpec* out) {
          out->dt = read_number(v, path, between(kLeastStep, kLongestStep));
          out->dt_given = true;
        });
  t.choice("integrator", &StepSpec::integrator, integrator_names(), "Time scheme.");
  t.add({"precision", "word", "", "double", "double, single",
         "Of cloth on grids with substepped_verlet and line_dual, and of springs on any mesh with substepped_verlet: "
         "single costs half and has an error of about 1e-4 of its own."},
        [](const YamlValue& v, const std::string& path, StepSpec* out) {
          const bool single = read_choice(v, path, {"double", "single"}) == "single";
          out->solver.precision = single ? SolverSettings::Precision::kSingle : SolverSettings::Precision::kDouble;
        });
  t.number(
      "fraction_of_limit", "", [](StepSpec& s) -> double& { return s.solver.fraction_of_limit; }, above(0, 0.95),
      "Length of the parts of substepped_verlet over the longest stable one; its error shrinks with the square.");
  t.add(
      {"linear_solver", "word", "", "banded with ropes alone, a stiff rope or a rope beside other bodies, else cg",
       "cg, direct, banded, multigrid",
       "Preconditioned conjugate gradient, sparse factorisation, factorisation of ropes and cg for all else, or "
       "conjugate "
       "gradient with multigrid (implicit_euler, bdf2 and tr_bdf2; cg with others): of scenes of nothing but cloth on "
       "grids of springs, without drag_coefficient, on rows of the grid, the matrix never assembled; of all others on "
       "aggregates of their nodes. The fastest at some percent. A rope is stiff when sqrt(EA / linear_density) dt > "
       "200 "
       "length / segments: a wave of tension passes 200 segments in a step; 20 when its material is a name."},
      [](const YamlValue& v, const std::string& path, StepSpec* out) {
        const std::string word = read_choice(v, path, {"cg", "direct", "banded", "multigrid"});
        out->solver.linear = word == "direct"      ? SolverSettings::Linear::kDirect
                             : word == "banded"    ? SolverSettings::Linear::kBanded
                             : word == "multigrid" ? SolverSettings::Linear::kMultigrid
                                                   : SolverSettings::Linear::kConjugateGradient;
        out->solver_given = true;
      });
  t.add({"newton_iterations", "integer", "", "100 with a stiff rope, 20 with ropes alone, else 4", "1 ... 1000",
         "At most, per step. Of line_dual and xpbd: sweeps, all of them made."},
        [](const YamlValue& v, const std::string& path, StepSpec* out) {
          out->solver.newton_iterations = read_integer(v, path, 1, 1000);
          out->iterations_given = true;
        });
  t.number(
      "tolerance", "m/s^2", [](StepSpec& s) -> double& { return s.solver.tolerance; }, above(0, 100),
      "RMS unbalanced acceleration at which Newton stops.");
  t.number(
      "linear_tolerance", "", [](StepSpec& s) -> double& { return s.solver.linear_tolerance; }, above(0, 0.5),
      "Relative residual of one linear solve (cg).");
  t.integer(
      "linear_iterations", [](StepSpec& s) -> int& { return s.solver.linear_iterations; }, 1, 100000,
      "At most, per linear solve (cg).");
  t.add(
      {"jacobian", "word", "", "lagged in scenes of ropes alone, else projected", "projected, lagged, axial",
       "What the matrix of springs is made of. projected: all but what makes it indefinite; lagged: the same with the "
       "tension at the start of the step, and (banded, away from contacts) whole Newton steps, for stiff ropes; axial: "
       "the part along the spring alone, as often published, for comparison."},
      [](const YamlValue& v, const std::string& path, StepSpec* out) {
        const std::string word = read_choice(v, path, {"projected", "lagged", "axial"});
        out->solver.jacobian = word == "axial"    ? Jacobian::kAxial
                               : word == "lagged" ? Jacobian::kLagged
                                                  : Jacobian::kProjected;
        out->jacobian_given = true;
      });
  return t;
}

std::vector<TaggedTable> collider_tables() {
  using P = PrimitiveText;
  const Range size = between(0.0001, 1000);
  const auto start = [](const std::string& tag, const std::string& doc) {
    Table<P> t("colliders[]." + tag, doc);
    t.name("name", &P::name, "Unique among colliders.");
    t.map("pose", &P::pose, pose_table(), "World from collider (from `frame`, when given). See pose.");
    t.number("friction", "", &P::friction, kFriction, "Coulomb coefficient.");
    t.text("frame", &P::frame, "tf frame the collider is attached to (ROS only); empty = fixed in the world.");
    t.add(
        {"lets_through", "list of names", "", "[]", "bodies", "Bodies that it does not touch."},
        [](const YamlValue& v, const std::string& path, P* out) { out->lets_through = read_names(v, path, "bodies"); });
    return t;
  };
  std::vector<TaggedTable> tables{
      {"box", start("box", "A box centred on its pose.")},
      {"sphere", start("sphere", "A ball centred on its pose.")},
      {"cylinder", start("cylinder", "A cylinder along z of its pose, centred on it.")},
      {"capsule", start("capsule", "A cylinder with round ends along z of its pose, centred on it.")},
      {"plane", start("plane", "A half-space: everything below z = 0 of its pose.")},
      {"cone", start("cone", "A cone along z of its pose, tip up, its middle height on it.")},
      {"mesh", start("mesh",
                     "A solid bounded by triangles, convex or not. The mesh has to be closed; parts that are "
                     "not joined are solids of their own. See doc/theory/contact.md.")},
      {"octomap", start("octomap",
                        "The occupied voxels of an OctoMap tree, in its own coordinates; free and unknown space is "
                        "empty. At most 500 000 voxels.")}};
  tables[0].table.vector("size", "[x, y, z]", "m", &P::size, size, "Full edge lengths.").required();
  for (size_t k : {1, 2, 3, 5}) tables[k].table.number("radius", "m", &P::radius, size, "Radius.").required();
  tables[2].table.number("length", "m", &P::length, size, "Length.").required();
  tables[3].table.number("length", "m", &P::length, size, "Of the straight part.").required();
  tables[5].table.number("length", "m", &P::length, size, "From the base to the tip.").required();
  tables[6]
      .table.text("file", &P::file, "OBJ, STL, PLY or DAE; relative to the scene, or package://deformable_sim/...")
      .required();
  tables[6].table.number("scale", "m", &P::scale, between(1e-6, 1000), "Metres per unit of the file.");
  tables[7]
      .table.text("file", &P::file, ".bt or .ot; relative to the scene, or package://deformable_sim/...")
      .required();
  return tables;
}

Table<SelectText> select_table() {
  using S = SelectText;
  Table<S> t("grasps[].select", "Which nodes are grasped.");
  t.text(
      "feature", &S::feature,
      "A feature of the body: grid corner_0..3, edge_0..3, center; rope end_0, end_1, center; cloth mesh center; soft "
      "face_x0, face_x1, face_y0 ... face_z1, center, and of a box corner_0..7.");
  t.add({"nodes", "list of integers", "", "", "nodes of the body", "Node numbers."},
        [](const YamlValue& v, const std::string& path, S* out) {
          for (const YamlValue& item : read_list(v, path, "node numbers")) {
            const std::string at = path + "[" + std::to_string(out->nodes.size()) + "]";
            out->nodes.push_back(read_integer(item, at, 0, kMaxNodes - 1));
          }
          if (out->nodes.empty()) refuse(v, path, "must name at least one node");
        });
  const auto position = [](std::optional<Vec3> S::*member) {
    return [member](const YamlValue& v, const std::string& path, S* out) {
      (out->*member).emplace();
      read_vector(v, path, kCoordinate, (out->*member)->data(), 3);
    };
  };
  t.add({"nearest", "[x, y, z]", "m", "", kCoordinate.text(), "The node nearest to this point of the world."},
        position(&S::nearest));
  t.number("reach", "m", &S::reach, above(0, 1000), "How far the nearest node may be.");
  t.optional_number("radius", "m", &S::radius, above(0, 1000), "", "All nodes this near to `center`.");
  t.vector("center", "[x, y, z]", "m", &S::center, kCoordinate, "Of the ball that `radius` gives.");
  t.add({"box", "[x, y, z]", "m", "", "> 0, <= 1000", "All nodes in a box of these edge lengths, centred on `pose`."},
        [](const YamlValue& v, const std::string& path, S* out) {
          out->box.emplace();
          read_vector(v, path, above(0, 1000), out->box->data(), 3);
        });
  t.map("pose", &S::pose, pose_table(), "Of the box. See pose.");
  t.exactly_one_of({"feature", "nodes", "nearest", "radius", "box"});
  return t;
}

Table<GraspText> grasp_table() {
  using G = GraspText;
  Table<G> t("grasps[]", "A grasp present from the start. Its nodes are attached rigidly, as they lie, to its frame.");
  t.name(
      "name", [](G& g) -> std::string& { return g.request.name; }, "Unique; part of topic names.");
  t.text(
       "body", [](G& g) -> std::string& { return g.request.body; }, "The body grasped.")
      .required();
  t.map("select", &G::select, select_table(), "Which nodes. See grasps[].select.").required();
  t.add({"pose", "map", "", "centroid of the nodes", "",
         "World from grasp: the frame moves and torques refer to. See pose."},
        [](const YamlValue& v, const std::string& path, G* out) { pose_table().read(v, path, &out->pose.emplace()); });
  t.number(
      "max_force", "N", [](G& g) -> double& { return g.request.max_force; }, between(0, 1e6),
      "The grasp slips off beyond; 0 = holds always.");
  t.number(
      "max_speed", "m/s", [](G& g) -> double& { return g.request.max_speed; }, between(0, 100),
      "Targets are approached no faster; 0 = grasp_max_speed.");
  t.number(
      "stiffness", "N/m", [](G& g) -> double& { return g.request.stiffness; }, between(0, 1e8),
      "Of the attachment; 0 = rigid.");
  t.text(
      "follow_frame", [](G& g) -> std::string& { return g.request.follow_frame; },
      "tf frame the grasp is rigidly attached to (ROS only).");
  return t;
}

Table<ForceRequest> force_table() {
  using F = ForceRequest;
  Table<F> t("forces[]", "A force that a plugin makes (ROS only). See doc/extending.md.");
  t.text("plugin", &F::plugin, "PACKAGE/CLASS, as its package exports it.").required();
  t.text("body", &F::body, "The body it acts on; left out: all.");
  t.add({"parameters", "map", "", "{}", "", "Numbers, or lists of numbers, by the names that the plugin knows."},
        [](const YamlValue& v, const std::string& path, F* out) {
          if (v.kind != YamlValue::Kind::kMap) refuse(v, path, "must be a map of numbers and lists of numbers");
          for (const YamlValue& item : v.items) {
            std::vector<double>& values = out->parameters[item.key];
            const std::string item_path = path + "." + item.key;
            if (item.kind != YamlValue::Kind::kList) {
              values = {read_number(item, item_path, kAnyNumber)};
              continue;
            }
            for (size_t k = 0; k < item.items.size(); ++k)
              values.push_back(read_number(item.items[k], item_path + "[" + std::to_string(k) + "]", kAnyNumber));
          }
        });
  return t;
}

Table<EventText> script_table() {
  using E = EventText;
  Table<E> t("script[]",
             "Something that happens by itself, between two steps. ~reset begins the script again; services and topics "
             "may grasp, move and release beside it.");
  t.number("at", "s", &E::at, between(0, 1e6), "Simulated time; no earlier than that of the event before.").required();
  t.add(
      {"grasp", "map", "", "", "", "A new grasp, of nodes where they are then. See grasps[]."},
      [](const YamlValue& v, const std::string& path, E* out) { grasp_table().read(v, path, &out->grasp.emplace()); });
  t.text("release", &E::release, "The grasp that lets go.");
  t.text("move_grasp", &E::move_grasp, "The grasp that goes to `pose`.");
  t.text("move_collider", &E::move_collider, "The collider that goes to `pose`.");
  t.add({"pose", "map", "", "required by moves", "",
         "World from grasp or collider, straight and slerped: turned about its origin alone, a grasp carries its nodes "
         "along an arc. See pose."},
        [](const YamlValue& v, const std::string& path, E* out) { pose_table().read(v, path, &out->pose.emplace()); });
  t.number("duration", "s", &E::duration, between(0, 1e6), "Of a move; 0 = as fast as max_speed allows.");
  return t.exactly_one_of({"grasp", "release", "move_grasp", "move_collider"});
}

Table<RobotSpec> robot_table() {
  Table<RobotSpec> t("robot", "Collide with the links of the ROS parameter robot_description, posed by tf (ROS only).");
  const auto names = [](std::vector<std::string> RobotSpec::*member) {
    return [member](const YamlValue& v, const std::string& path, RobotSpec* robot) {
      robot->*member = read_names(v, path, "link names");
    };
  };
  t.add({"links", "list of names", "", "all", "", "Links with collision elements."}, names(&RobotSpec::links));
  t.add({"exclude", "list of names", "", "[]", "", "Links that are no obstacles."}, names(&RobotSpec::exclude));
  t.add({"lets_through", "map", "", "{}", "links, bodies",
         "Which bodies a link does not touch: `{left_finger: [towel, rope]}`."},
        [](const YamlValue& v, const std::string& path, RobotSpec* robot) {
          if (v.kind != YamlValue::Kind::kMap) refuse(v, path, "must be a map of links and lists of bodies");
          for (const YamlValue& item : v.items)
            robot->lets_through[item.key] = read_names(item, path + "." + item.key, "bodies");
        });
  t.number("padding", "m", &RobotSpec::padding, between(0, 1), "How much larger than in the URDF every shape is.");
  t.number("friction", "", &RobotSpec::friction, kFriction, "Coulomb coefficient of the links.");
  return t;
}

Table<OutputSpec> output_table() {
  Table<OutputSpec> t("outputs", "What is published, and how it looks (ROS only).");
  t.number("rate_markers", "Hz", &OutputSpec::rate_markers, kRate, "0 = never.");
  t.number("rate_points", "Hz", &OutputSpec::rate_points, kRate, "0 = never.");
  t.number("rate_state", "Hz", &OutputSpec::rate_state, kRate, "0 = never.");
  t.choice("color_by", &OutputSpec::color_by, {"body", "strain", "stress", "velocity", "contact"},
           "What the colour shows; stress: of membranes and soft bodies.");
  t.number("strain_range", "", &OutputSpec::strain_range, between(1e-6, 10), "Strain shown as full colour.");
  t.number("stress_range", "Pa", &OutputSpec::stress_range, between(1e-3, 1e12), "Stress shown as full colour.");
  t.boolean("wireframe", &OutputSpec::wireframe, "Also draw the edges.");
  t.boolean("frames", &OutputSpec::frames, "Also draw the frames of rods.");
  t.boolean("shadows", &OutputSpec::shadows,
            "Also draw what bodies shade, along gravity, of planes and tops of boxes that are horizontal.");
  t.boolean("contact_arrows", &OutputSpec::contact_arrows, "Also draw the force of every contact as an arrow.");
  t.add({"contact_scale", "number", "m/N", "the longest arrow is a fifth of the scene", "> 0, <= 1000000",
         "Length of the arrows."},
        [](const YamlValue& v, const std::string& path, OutputSpec* out) {
          out->contact_scale = read_number(v, path, above(0, 1e6));
        });
  t.boolean("legend", &OutputSpec::legend,
            "Also draw a bar with the numbers of the colours, where color_by is not body.");
  t.add({"legend_position", "[x, y, z]", "m", "beside the bodies at the start", kCoordinate.text(),
         "Foot of the bar, in the world."},
        [](const YamlValue& v, const std::string& path, OutputSpec* out) {
          read_vector(v, path, kCoordinate, out->legend_position.emplace().data(), 3);
        });
  t.add({"legend_height", "number", "m", "half the size of the scene", "> 0, <= 1000", "Height of the bar."},
        [](const YamlValue& v, const std::string& path, OutputSpec* out) {
          out->legend_height = read_number(v, path, above(0, 1000));
        });
  return t;
}

Table<SceneSpec> scene_table(const SceneListReaders& lists) {
  Table<SceneSpec> t("", "The file itself. Only `bodies` is required.");
  t.text("title", &SceneSpec::title, "One line, shown by tools.");
  t.vector("gravity", "[x, y, z]", "m/s^2", &SceneSpec::gravity, between(-1000, 1000), "Acceleration of free fall.");
  t.map("air", &SceneSpec::air, air_table(), "See air.");
  t.add({"step", "map or word", "", "", "auto", "See step. auto: {control: error}."},
        [](const YamlValue& v, const std::string& path, SceneSpec* out) {
          if (v.kind == YamlValue::Kind::kScalar) {
            read_choice(v, path, {"auto"});
            out->step.control = StepControl::kError;
          } else {
            step_table().read(v, path, &out->step);
          }
        });
  t.number("grasp_max_speed", "m/s", &SceneSpec::grasp_max_speed, above(0, 100), "For grasps that name no max_speed.");
  t.add({"bodies", "list", "", "", "at least one",
         "Each a map with one key: `- cloth: {...}`, `- rope: {...}` or `- soft: {...}`."},
        lists.bodies)
      .required();
  t.add({"colliders", "list", "", "[]", "",
         "Each a map with one key: box, sphere, cylinder, capsule, plane, cone, mesh or octomap."},
        lists.colliders);
  t.add({"grasps", "list", "", "[]", "", "Each a map. See grasps[]."}, lists.grasps);
  t.add({"forces", "list", "", "[]", "", "Each a map. See forces[]."}, lists.forces);
  t.add({"script", "list", "", "[]", "", "Each a map, in the order of time. See script[]."}, lists.script);
  t.add({"robot", "map", "", "no robot", "", "See robot. `robot: {}` takes all links."},
        [](const YamlValue& v, const std::string& path, SceneSpec* scene) {
          scene->robot.present = true;
          robot_table().read(v, path, &scene->robot);
          if (const YamlValue* given = v.find("lets_through"))
            for (const YamlValue& link : given->items) check_bodies(link, path + ".lets_through." + link.key, *scene);
        });
  t.map("outputs", &SceneSpec::outputs, output_table(), "See outputs.");
  return t;
}

}  // namespace deformable_sim
