// Every model, material, law and scheme that a scene can name: what it builds, and that it steps.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "deformable_sim/core/energy/known_terms.h"
#include "deformable_sim/core/integrator/integrator.h"
#include "deformable_sim/core/material/solid_law.h"
#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"
#include "deformable_sim/scene/material_library.h"

namespace deformable_sim {
namespace {

SceneSpec scene(const std::string& yaml) {
  return load_scene_text(yaml, "s.yaml");
}

std::vector<std::string> terms_of(const Model& model) {
  std::vector<std::string> names;
  for (const auto& energy : model.energies) names.push_back(energy->name());
  return names;
}

double elastic_energy(const Model& model, const State& s) {
  double sum = 0.0;
  for (const auto& term : model.energies) sum += term->value(s);
  return sum;
}

void expect_steps(const std::string& yaml, int count) {
  const std::unique_ptr<World> world = build_world(scene(yaml));
  for (int k = 0; k < count; ++k) {
    const StepOutcome outcome = world->step();
    ASSERT_TRUE(outcome.ok) << outcome.message << "\n" << yaml;
  }
  ASSERT_TRUE(world->state().finite()) << yaml;
  const Snapshot now = world->snapshot();
  for (const BodyReport& body : now.bodies) {
    EXPECT_LT(body.max_strain, 0.5) << yaml;
    EXPECT_TRUE(std::isfinite(body.elastic_energy)) << yaml;
  }
}

const char kCloth[] = "name: c, size: [0.2, 0.15], cells: [4, 3], pins: [edge_0]";
const char kRope[] = "name: r, length: 0.4, segments: 10, pins: [end_0]";
const char kSoft[] = "name: s, pins: [face_x0]";

TEST(EveryLawOfSolids, StepsWithEveryElement) {
  for (const std::string& law : solid_law_names()) {
    for (const char* element : {"tetrahedron", "quadratic_tetrahedron"}) {
      expect_steps(std::string("bodies:\n  - soft: {") + kSoft +
                       ", box: {size: [0.2, 0.1, 0.1], cells: [2, 1, 1]}, law: " + law + ", element: " + element +
                       "}\n",
                   20);
    }
  }
}

TEST(EveryLawOfSheets, StepsWithEveryKindOfBending) {
  for (const std::string& law : solid_law_names()) {
    for (const char* bending : {"hinges", "quadratic"}) {
      expect_steps(std::string("bodies:\n  - cloth: {") + kCloth + ", model: membrane, law: " + law +
                       ", bending: " + bending + ", material: {bending_rigidity: 1e-5}}\n",
                   20);
    }
  }
}

TEST(EveryKindOfMass, Steps) {
  for (const char* integrator : {"implicit_euler", "bdf2"}) {
    for (const char* element : {"tetrahedron", "quadratic_tetrahedron"}) {
      expect_steps(std::string("step: {dt: 0.002, integrator: ") + integrator + "}\nbodies:\n  - cloth: {" + kCloth +
                       "}\n  - soft: {" + kSoft +
                       ", box: {size: [0.2, 0.1, 0.1], cells: [2, 1, 1]}, mass: consistent, element: " + element +
                       "}\n",
                   10);
    }
  }
  const auto model =
      build_model(scene("bodies:\n  - cloth: {name: c, cells: [2, 2]}\n"
                        "  - soft: {name: s, box: {size: [1, 1, 1], cells: [1, 1, 1]}, mass: consistent}\n"));
  EXPECT_NEAR(model->mass_matrix.sum(), model->mass.sum(), 1e-9) << "M 1 = m";
  EXPECT_EQ(model->mass_matrix.coeff(0, 0), model->mass[0]) << "cloth is lumped";
}

TEST(EverySpringModel, StepsWithEveryKindOfBending) {
  for (const char* model : {"springs", "provot"}) {
    for (const char* more : {"", ", bending: hinges, material: {bending_rigidity: 1e-5}",
                             ", bending: quadratic, material: {bending_rigidity: 1e-5}", ", strain_limit: 0.02"}) {
      expect_steps(std::string("bodies:\n  - cloth: {") + kCloth + ", model: " + model + more + "}\n", 20);
    }
  }
  for (const char* neighbours : {"18", "26"}) {
    expect_steps(std::string("bodies:\n  - soft: {") + kSoft +
                     ", box: {size: [0.2, 0.1, 0.1], cells: [4, 2, 2]}, element: springs, neighbours: " + neighbours +
                     "}\n",
                 20);
  }
}

TEST(EveryScheme, MovesAClothARopeARodAndASoftBody) {
  // 20 ms: gravity has moved everything by g t^2 / 2 = 2 mm, less what holds it. Those that know springs and quadratic
  // bending only refuse the rest by name.
  for (const std::string& scheme : integrator_names()) {
    for (const std::string& body :
         {std::string("cloth: {") + kCloth + "}", std::string("cloth: {") + kCloth + ", model: membrane}",
          std::string("rope: {") + kRope + ", material: {youngs_modulus: 1e6}}",
          std::string("rope: {") + kRope + ", model: rod, material: {youngs_modulus: 1e6}}",
          std::string("soft: {") + kSoft + ", box: {size: [0.2, 0.1, 0.1], cells: [2, 1, 1]}}"}) {
      const std::string yaml = "step: {dt: 0.002, integrator: " + scheme + "}\nbodies:\n  - " + body + "\n";
      const bool known = body.find("membrane") == std::string::npos && body.find("rod") == std::string::npos &&
                         body.find("soft") == std::string::npos;
      if (known || !takes_known_terms_only(scheme)) {
        expect_steps(yaml, 10);
      } else {
        EXPECT_THROW(build_world(scene(yaml)), InputError) << yaml;
      }
    }
  }
}

TEST(EveryJacobian, SolvesTheSameHangingCloth) {
  for (const char* jacobian : {"projected", "axial"}) {
    expect_steps(std::string("step: {jacobian: ") + jacobian + "}\nbodies:\n  - cloth: {" + kCloth + "}\n", 20);
  }
}

TEST(EveryMaterialOfTheTables, MakesABody) {
  const MaterialLibrary library = load_material_library(default_material_dir());
  for (const FabricData& fabric : library.fabrics) {
    const auto model =
        build_model(scene("bodies:\n  - cloth: {name: a, size: [1, 1], cells: [4, 4], model: membrane, material: " +
                          fabric.origin.name + "}\n"));
    EXPECT_NEAR(model->mass.sum(), fabric.areal_density, 1e-12) << fabric.origin.name;
    EXPECT_NO_THROW(
        build_model(scene("bodies:\n  - cloth: {name: a, material: {from: " + fabric.origin.name + "}}\n")));
  }
  for (const RopeData& rope : library.ropes) {
    for (const char* kind : {"springs", "rod"}) {
      const auto model = build_model(scene(std::string("bodies:\n  - rope: {name: a, length: 2, model: ") + kind +
                                           ", material: " + rope.origin.name + "}\n"));
      EXPECT_NEAR(model->mass.head(model->point_count()).sum(), 2 * rope.linear_density, 1e-9) << rope.origin.name;
      EXPECT_EQ(model->bodies[0].valid_strain[1], rope.breaking_strain) << rope.origin.name;
    }
  }
  for (const SolidData& solid : library.solids) {
    const auto model = build_model(
        scene("bodies:\n  - soft: {name: a, box: {size: [1, 1, 1], cells: [1, 1, 1]}, material: " + solid.origin.name +
              "}\n"));
    EXPECT_NEAR(model->mass.sum(), solid.density, 1e-9 * solid.density) << solid.origin.name;
    EXPECT_EQ(terms_of(*model)[0], "quadratic tetrahedra: " + solid.law) << solid.origin.name;
  }
}

TEST(MaterialMaps, ReplaceWhatTheNamedMaterialGives) {
  const SceneSpec s = scene(
      "bodies:\n"
      "  - cloth: {name: a, model: membrane, material: {from: cotton_voile, areal_density: 0.5}}\n"
      "  - cloth: {name: b, model: membrane, material: {from: cotton_voile, youngs_modulus: 1e6, thickness: 0.001}}\n"
      "  - soft: {name: c, box: {size: [1, 1, 1]}, material: {from: rubber, density: 2}, law: corotational}\n");
  const FabricData voile = load_material_library(default_material_dir()).fabric("cotton_voile");
  EXPECT_EQ(s.bodies[0].cloth_material.areal_density, 0.5);
  EXPECT_EQ(s.bodies[0].cloth_material.membrane()[0], voile.traction_warp());
  EXPECT_EQ(s.bodies[0].cloth_material.membrane()[1], voile.traction_weft());
  EXPECT_EQ(s.bodies[1].cloth_material.membrane()[0], 1000.0) << "youngs_modulus x thickness again";
  EXPECT_EQ((*s.bodies[1].cloth_material.bending_rigidity)[1], voile.bend_weft);
  EXPECT_EQ(s.bodies[2].soft.material.density, 2.0);
  EXPECT_EQ(s.bodies[2].soft.law, "corotational");
}

TEST(Membrane, IsAsStiffAsItsWarpAndItsWeft) {
  // Pulled along one direction, the sides held: E h / (1 - nu_12 nu_21) strain^2 / 2 per area, nu_21 = nu_12 weft /
  // warp.
  const auto model = build_model(scene(
      "gravity: [0, 0, 0]\nbodies:\n  - cloth: {name: a, size: [2, 1], cells: [6, 4], model: membrane, law: hooke,\n"
      "      material: {membrane_stiffness: [400, 100], poissons_ratio: 0.3, shear_rigidity: 7}}\n"));
  const double held = 1.0 - 0.3 * 0.3 * 0.25;
  const auto energy = [&](const Mat3& gradient) {
    State s = model->initial;
    s.x = gradient * s.x;
    return elastic_energy(*model, s);
  };
  EXPECT_NEAR(energy(Vec3(1.001, 1, 1).asDiagonal()), 0.5 * 400 / held * 1e-6 * 2, 1e-12);
  EXPECT_NEAR(energy(Vec3(1, 1.001, 1).asDiagonal()), 0.5 * 100 / held * 1e-6 * 2, 1e-12);
  Mat3 shear = Mat3::Identity();
  shear(0, 1) = 0.001;
  EXPECT_NEAR(energy(shear), 0.5 * 7 * 1e-6 * 2, 1e-12);
}

TEST(Hinges, GiveAnyModelTheRigidityAsked) {
  // Bent along warp to a radius R, inextensible, free across: energy B / (2 (1 - nu^2) R^2) per area, up to what the
  // end cells, whose outer halves no hinge bends, leave out: one part in the number of cells.
  for (const char* model : {"springs", "provot", "membrane"}) {
    const auto built =
        build_model(scene(std::string("gravity: [0, 0, 0]\nbodies:\n  - cloth: {name: a, size: [0.4, 0.2], "
                                      "cells: [40, 20], model: ") +
                          model + ",\n      material: {bending_rigidity: [4e-4, 1e-4], poissons_ratio: 0}}\n"));
    State s = built->initial;
    const double radius = 0.5;
    for (int i = 0; i < s.x.cols(); ++i) {
      const double angle = s.x(0, i) / radius;
      s.x(0, i) = radius * std::sin(angle);
      s.x(2, i) = radius * (1.0 - std::cos(angle));
    }
    double bending = 0.0;
    for (const auto& term : built->energies) {
      if (term->name().find("bend") != std::string::npos) bending += term->value(s);
    }
    EXPECT_NEAR(bending, 0.5 * 4e-4 / (radius * radius) * 0.4 * 0.2, 0.05 * 6.4e-5) << model;
  }
}

TEST(Creases, AreSharpAtRestAndNowhereElse) {
  // The pressed angle is the only one without energy: a sheet folded to it along the line keeps just that.
  const auto model = build_model(
      scene("gravity: [0, 0, 0]\nbodies:\n  - cloth: {name: a, size: [0.4, 0.2], cells: [8, 4], model: membrane,\n"
            "      material: {bending_rigidity: 1e-3},\n"
            "      creases: [{from: [0, -0.1], to: [0, 0.1], angle: 0.6}]}\n"));
  const auto folded = [&](double angle) {
    State s = model->initial;
    for (int i = 0; i < s.x.cols(); ++i) {
      const double x = s.x(0, i);
      s.x(0, i) = x * std::cos(0.5 * angle);
      s.x(2, i) = std::abs(x) * std::sin(0.5 * angle);
    }
    return elastic_energy(*model, s);
  };
  EXPECT_NEAR(folded(0.6), 0.0, 1e-12) << "a valley on the +z side";
  EXPECT_GT(folded(0.0), 1e-4);
  EXPECT_GT(folded(-0.6), folded(0.0));
  EXPECT_GT(folded(0.9), 1e-5);
}

TEST(RestShape, IsTheMeshOrFlat) {
  const std::string shirt = "bodies:\n  - cloth: {name: a, mesh: " + std::string(DEFORMABLE_SIM_SOURCE_DIR) +
                            "/meshes/tshirt.obj, model: membrane, material: {bending_rigidity: 1e-5}, rest_shape: ";
  const auto meshed = build_model(scene("gravity: [0, 0, 0]\n" + shirt + "as_meshed}\n"));
  const auto flat = build_model(scene("gravity: [0, 0, 0]\n" + shirt + "flat}\n"));
  EXPECT_NEAR(elastic_energy(*meshed, meshed->initial), 0.0, 1e-12);
  EXPECT_GT(elastic_energy(*flat, flat->initial), 1e-4) << "its seams are folded";
}

TEST(Rod, StartsWithoutEnergyInItsNaturalShape) {
  // A circle of curvature 8 /m turns by 8 x 0.5 = 4 rad along its length.
  const std::string rod = "gravity: [0, 0, 0]\nbodies:\n  - rope: {name: a, length: 0.5, segments: 50, model: rod, ";
  for (const char* shape :
       {"natural_curvature: 8", "natural_curvature: [3, -5], natural_twist: 6", "natural_twist: 9"}) {
    const auto model = build_model(scene(rod + shape + "}\n"));
    EXPECT_NEAR(elastic_energy(*model, model->initial), 0.0, 1e-10) << shape;
    EXPECT_EQ(model->angle_count, 50);
  }
  const auto circle = build_model(scene(rod + "natural_curvature: 8}\n"));
  const auto tangent = [&](int k) {
    return Vec3(circle->initial.x.col(k + 1) - circle->initial.x.col(k)).normalized();
  };
  const double turn = std::atan2(tangent(49).y(), tangent(49).x());
  EXPECT_LT((tangent(0) - Vec3::UnitX()).norm(), 1e-12);
  EXPECT_NEAR(std::remainder(turn - 8 * 0.5 * 49 / 50, 2 * M_PI), 0.0, 1e-9) << "towards y";
  // EI kappa^2 / 2 per length, over the 49 joints.
  const auto straight =
      build_model(scene(rod + "natural_curvature: 8, start: straight, material: {bending_rigidity: 1}}\n"));
  EXPECT_NEAR(elastic_energy(*straight, straight->initial), 0.5 * 8 * 8 * 0.49, 1e-3);
}

TEST(Rod, StartsTurnedByItsInitialTwist) {
  // GJ tau^2 / 2 per length, over the 49 joints.
  const auto model = build_model(scene(
      "gravity: [0, 0, 0]\nbodies:\n  - rope: {name: a, length: 0.5, segments: 50, model: rod, initial_twist: 4,\n"
      "      material: {twist_rigidity: 0.01}}\n"));
  EXPECT_NEAR(elastic_energy(*model, model->initial), 0.5 * 0.01 * 16 * 0.49, 1e-12);
}

TEST(Rod, HasTheStiffnessesOfItsSection) {
  // Round: EI = E pi d^4 / 64, GJ = G pi d^4 / 32. Square of side a: GJ = 0.140577 G a^4 [Timoshenko Goodier 1970].
  // Shown by rods of natural twist or curvature that start straight: energy EI kappa^2 / 2 or GJ tau^2 / 2 per length.
  const auto energy = [](const std::string& keys) {
    const auto model = build_model(scene(
        "gravity: [0, 0, 0]\nbodies:\n  - rope: {name: a, length: 1, segments: 100, model: rod, start: straight, " +
        keys + "}\n"));
    return elastic_energy(*model, model->initial) / 0.99;
  };
  const std::string round = "material: {youngs_modulus: 2e9, shear_modulus: 7e8, diameter: 0.01}";
  EXPECT_NEAR(energy("natural_curvature: 0.1, " + round), 0.5 * 2e9 * M_PI * 1e-8 / 64 * 0.01, 1e-7);
  const std::string flat = "material: {youngs_modulus: 2e9, shear_modulus: 7e8, section: [0.02, 0.001]}";
  EXPECT_NEAR(energy("natural_curvature: [0.1, 0], " + flat), 0.5 * 2e9 * 0.02 * 1e-9 / 12 * 0.01, 1e-9);
  EXPECT_NEAR(energy("natural_curvature: [0, 0.1], " + flat), 0.5 * 2e9 * 0.001 * 8e-6 / 12 * 0.01, 1e-7);
}

TEST(SoftBodies, HaveTheFeaturesOfTheirBox) {
  const auto model =
      build_model(scene("bodies:\n  - soft: {name: a, box: {size: [0.3, 0.2, 0.1], cells: [3, 2, 1]}, element: "
                        "tetrahedron, pose: {position: [0, 0, 1]}}\n"));
  const Body& body = model->bodies[0];
  EXPECT_EQ(body.kind, BodyKind::kSoft);
  EXPECT_EQ(body.node_count, 24);
  EXPECT_EQ(body.features.at("face_x0").size(), 6u);
  EXPECT_EQ(body.features.at("face_z1").size(), 12u);
  for (const int node : body.features.at("face_x1")) EXPECT_NEAR(model->initial.x(0, node), 0.15, 1e-12);
  EXPECT_LT((model->initial.x.col(body.features.at("corner_0")[0]) - Vec3(-0.15, -0.1, 0.95)).norm(), 1e-12);
  EXPECT_LT((model->initial.x.col(body.features.at("corner_5")[0]) - Vec3(0.15, -0.1, 1.05)).norm(), 1e-12);
  EXPECT_NEAR(model->mass.sum(), 1000 * 0.3 * 0.2 * 0.1, 1e-12);
}

TEST(SoftBodies, ChooseCubesForThemselves) {
  const auto cells = [](const std::string& size) {
    return build_model(scene("bodies:\n  - soft: {name: a, box: {size: " + size + "}}\n"))->bodies[0].node_count;
  };
  EXPECT_EQ(cells("[0.1, 0.1, 0.1]"), 5 * 5 * 5);
  EXPECT_EQ(cells("[0.2, 0.1, 0.05]"), 17 * 9 * 5);
  EXPECT_EQ(cells("[1, 1, 0.001]"), 21 * 21 * 3) << "at most 10 quadratic ones along a side";
}

TEST(SoftBodies, TouchWithTheirSurfaceOnly) {
  const auto world = build_world(
      scene("bodies:\n  - soft: {name: a, box: {size: [0.1, 0.1, 0.1], cells: [4, 4, 4]}, element: tetrahedron}\n"
            "colliders:\n  - plane: {name: floor, pose: {position: [0, 0, -0.2]}}\n"));
  for (const BillItem& item : world->bill()) {
    if (item.part != "contact") continue;
    EXPECT_EQ(item.detail, "98 points, 1 shapes") << "125 nodes less 27 inside";
  }
}

TEST(SoftBodies, MadeOfASurfaceCarryItAlong) {
  const auto model = build_model(scene("bodies:\n  - soft: {name: a, mesh: " + std::string(DEFORMABLE_SIM_SOURCE_DIR) +
                                       "/meshes/soft_toy.obj, lattice: {cell: 0.03}}\n"));
  const Body& body = model->bodies[0];
  ASSERT_TRUE(body.skin);
  EXPECT_EQ(body.skin->vertex_count(), 3326);
  EXPECT_LT(body.node_count, 500);
  const Vec3 move(0.1, 0.2, 0.3);
  const Nodes moved = model->initial.x.colwise() + move;
  const Nodes skin = body.skin->positions(moved);
  EXPECT_LT((skin - (body.skin->surface().rest.colwise() + move)).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(SoftBodies, OfTetrahedraInAFileAreBuilt) {
  const std::string path = testing::TempDir() + "/two_tetrahedra.mesh";
  std::ofstream(path)
      << "MeshVersionFormatted 2\nDimension 3\nVertices 5\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 0\n1 1 1 0\n"
         "Tetrahedra 2\n1 2 3 5 0\n4 1 2 3 0\n";
  for (const char* element : {"tetrahedron", "quadratic_tetrahedron"}) {
    const auto model = build_model(
        scene("bodies:\n  - soft: {name: a, mesh: " + path + ", mesh_scale: 0.1, element: " + element + "}\n"));
    EXPECT_NEAR(model->mass.sum(), 1000 * 0.5 * 1e-3, 1e-12);
    EXPECT_EQ(model->bodies[0].node_count, element[0] == 't' ? 5 : 14);
  }
}

TEST(Notes, SayWhatAModelCannotRepresent) {
  const auto note = [](const std::string& body) {
    const auto world = build_world(scene("bodies:\n  - " + body + "\n"));
    const std::vector<std::string> warnings = world->snapshot().warnings;
    return warnings.empty() ? std::string() : warnings[0];
  };
  const auto says = [&](const std::string& body, const std::string& what) {
    EXPECT_NE(note(body).find(what), std::string::npos) << body << ": '" << note(body) << "'";
  };
  says("soft: {name: a, box: {size: [0.4, 0.1, 0.1], cells: [4, 1, 1]}, element: tetrahedron}",
       "linear tetrahedra bend about");
  says(
      "soft: {name: a, box: {size: [0.4, 0.1, 0.1], cells: [4, 1, 1]}, element: quadratic_tetrahedron, "
      "material: {poissons_ratio: 0.49}}",
      "quadratic tetrahedra ten times as long as thick bends about 1.16 times");
  says("soft: {name: a, box: {size: [0.4, 0.1, 0.1], cells: [4, 1, 1]}, element: quadratic_tetrahedron, law: hooke}",
       "small rotations");
  says("soft: {name: a, box: {size: [1, 1, 1], cells: [2, 2, 2]}, element: springs, material: {poissons_ratio: 0.4}}",
       "0.25");
  says("rope: {name: a, material: nylon_rope}", "or rod shows it");
  says("cloth: {name: a, material: cotton_voile}", "model: membrane");
  EXPECT_EQ(note("soft: {name: a, box: {size: [0.1, 0.1, 0.1], cells: [1, 1, 1]}, element: quadratic_tetrahedron}"),
            "");
  EXPECT_EQ(note("soft: {name: a, box: {size: [1, 1, 1], cells: [2, 2, 2]}, element: springs}"), "");
  EXPECT_EQ(note("cloth: {name: a}"), "");
  EXPECT_EQ(note("rope: {name: a, model: rod}"), "");
}

TEST(State, OfASoftBodyIsSetAndHeld) {
  const auto world =
      build_world(scene("gravity: [0, 0, 0]\nbodies:\n  - cloth: {name: a, cells: [2, 2]}\n"
                        "  - soft: {name: b, box: {size: [0.1, 0.1, 0.1], cells: [2, 2, 2]}}\n"));
  const Body& body = world->model().bodies[1];
  command::SetBodyState set;
  set.body = "b";
  set.x = world->state().x.middleCols(body.first_node, body.node_count).colwise() + Vec3(0, 0, 1);
  set.v = Nodes::Zero(3, body.node_count);
  ASSERT_TRUE(world->apply(set).status.ok());
  ASSERT_TRUE(world->step().ok);
  EXPECT_LT((world->state().x.middleCols(body.first_node, body.node_count) - set.x).cwiseAbs().maxCoeff(), 1e-12);
}

}  // namespace
}  // namespace deformable_sim
