// Keys of models and materials that contradict each other are refused with the file, the line and the key.
#include <gtest/gtest.h>

#include "deformable_sim/scene/build.h"
#include "deformable_sim/scene/load.h"

namespace deformable_sim {
namespace {

struct Refusal {
  const char* title;
  std::string yaml;
  const char* message;  // how it begins
};

void PrintTo(const Refusal& refusal, std::ostream* out) {
  *out << refusal.title;
}

class ModelRefusals : public testing::TestWithParam<Refusal> {};

TEST_P(ModelRefusals, NameFileLineKeyAndWhatIsAllowed) {
  std::string message = "(accepted)";
  try {
    build_world(load_scene_text(GetParam().yaml, "s.yaml"));
  } catch (const InputError& error) {
    message = error.what();
  }
  EXPECT_EQ(message.rfind(GetParam().message, 0), 0u)
      << "expected: " << GetParam().message << "\ngot:      " << message;
  EXPECT_EQ(message.find('\n'), std::string::npos) << "one line";
}

/// Bodies with one more key at line 4 (of the body) or 5 (of its material).
std::string body(const std::string& kind, const std::string& first, const std::string& line) {
  return "bodies:\n  - " + kind + ":\n      {name: a, " + first + ",\n       " + line + "}\n";
}
std::string cloth(const std::string& line) {
  return body("cloth", "cells: [4, 3]", line);
}
std::string rope(const std::string& line) {
  return body("rope", "segments: 8", line);
}
std::string soft(const std::string& line) {
  return body("soft", "box: {size: [0.1, 0.1, 0.1], cells: [2, 2, 2]}", line);
}
std::string mesh_path(const std::string& file) {
  return std::string(DEFORMABLE_SIM_SOURCE_DIR) + "/" + file;
}

INSTANTIATE_TEST_SUITE_P(
    Cloth, ModelRefusals,
    testing::Values(
        Refusal{
            "model", cloth("model: membran"),
            "s.yaml:4: bodies[0].cloth.model: unknown 'membran'; did you mean 'membrane'? Allowed: springs, provot"},
        Refusal{"law", cloth("model: membrane, law: mooney"),
                "s.yaml:4: bodies[0].cloth.law: unknown 'mooney'; allowed: hooke, corotational"},
        Refusal{"rubber that gives way", soft("law: neo_hookean, material: {poissons_ratio: -0.1}"),
                "s.yaml:4: bodies[0].soft.material.poissons_ratio: law neo_hookean needs 0 or more"},
        Refusal{"law of springs", cloth("law: hooke"), "s.yaml:4: bodies[0].cloth.law: belongs to model: membrane"},
        Refusal{"bending", cloth("bending: angle"), "s.yaml:4: bodies[0].cloth.bending: unknown 'angle'"},
        Refusal{"rest shape", cloth("model: membrane, rest_shape: round"),
                "s.yaml:4: bodies[0].cloth.rest_shape: unknown 'round'"},
        Refusal{"rest shape of springs", cloth("rest_shape: flat"),
                "s.yaml:4: bodies[0].cloth.rest_shape: belongs to bending: hinges or quadratic"},
        Refusal{"creases of springs", cloth("creases: [{from: [0, 0], to: [1, 0], angle: 1}]"),
                "s.yaml:4: bodies[0].cloth.creases: belongs to bending: hinges"},
        Refusal{"creases of quadratic bending",
                cloth("model: membrane, bending: quadratic, creases: [{from: [0, 0], to: [1, 0], angle: 1}]"),
                "s.yaml:4: bodies[0].cloth.creases: belongs to bending: hinges; quadratic is flat at rest"},
        Refusal{"no list of creases", cloth("model: membrane, creases: {from: [0, 0]}"),
                "s.yaml:4: bodies[0].cloth.creases: must be a list of creases, not a map"},
        Refusal{"half a crease", cloth("model: membrane, creases: [{from: [0, 0], angle: 1}]"),
                "s.yaml:4: bodies[0].cloth.creases[0].to: required, and missing"},
        Refusal{"sharp crease", cloth("model: membrane, creases: [{from: [0, 0], to: [0.1, 0], angle: 3.2}]"),
                "s.yaml:4: bodies[0].cloth.creases[0].angle: 3.2 is out of range"},
        Refusal{"crease beside the edges",
                cloth("model: membrane, size: [0.4, 0.3],\n       creases: [{from: [0, 0], to: [0, 0.15], angle: 1},\n"
                      "                 {from: [0.03, -0.15], to: [0.03, 0.15], angle: 1}]"),
                "s.yaml:5: bodies[0].cloth.creases[0]: edges of the mesh cover"},
        Refusal{"crease without length", cloth("model: membrane, creases: [{from: [0, 0], to: [0, 0], angle: 1}]"),
                "s.yaml:4: bodies[0].cloth.creases[0]: the crease has no length"},
        Refusal{"strain limit", cloth("strain_limit: 0"),
                "s.yaml:4: bodies[0].cloth.strain_limit: 0 is out of range; allowed: 0.001 ... 1"},
        Refusal{"upsampling", cloth("visual: {upsample: 0}"),
                "s.yaml:4: bodies[0].cloth.visual.upsample: 0 is out of range; allowed: 1 ... 32"},
        Refusal{"upsampled mesh",
                "bodies:\n  - cloth: {name: a, mesh: " + mesh_path("meshes/tshirt.obj") + ", visual: {upsample: 2}}\n",
                "s.yaml:2: bodies[0].cloth.visual: is for grids"},
        Refusal{"provot mesh",
                "bodies:\n  - cloth: {name: a, mesh: " + mesh_path("meshes/tshirt.obj") + ", model: provot}\n",
                "s.yaml:2: bodies[0].cloth.model: provot is for grids"},
        Refusal{"curved mesh with quadratic bending",
                "bodies:\n  - cloth: {name: a, mesh: " + mesh_path("meshes/tshirt.obj") +
                    ", model: membrane, bending: quadratic}\n",
                "s.yaml:2: bodies[0].cloth.bending: quadratic is flat at rest: needs rest_shape: flat"}));

INSTANTIATE_TEST_SUITE_P(
    ClothMaterial, ModelRefusals,
    testing::Values(
        Refusal{"unknown name", cloth("material: cotton_viole"), "s.yaml:4: bodies[0].cloth.material: "},
        Refusal{"name of another kind", cloth("material: rubber"), "s.yaml:4: bodies[0].cloth.material: "},
        Refusal{"unknown name in a map", cloth("material: {from: silkk}"), "s.yaml:4: bodies[0].cloth.material.from: "},
        Refusal{"list", cloth("material: [cotton_voile]"), "s.yaml:4: bodies[0].cloth.material: must be a map"},
        Refusal{"unknown key", cloth("material: {bending_rigidty: 1}"),
                "s.yaml:4: bodies[0].cloth.material.bending_rigidty: unknown key; did you mean 'bending_rigidity'?"},
        Refusal{"two ways to say E h", cloth("material: {youngs_modulus: 1e6, membrane_stiffness: 100}"),
                "s.yaml:4: bodies[0].cloth.material.membrane_stiffness: excludes youngs_modulus"},
        Refusal{"warp of springs", cloth("material: {membrane_stiffness: [100, 200]}"),
                "s.yaml:4: bodies[0].cloth.material.membrane_stiffness: springs are the same along warp and weft"},
        Refusal{"shear rigidity of springs", cloth("material: {shear_rigidity: 10}"),
                "s.yaml:4: bodies[0].cloth.material.shear_rigidity: belongs to model: membrane"},
        Refusal{"springs of a membrane", cloth("model: membrane, material: {stretch_stiffness: 10}"),
                "s.yaml:4: bodies[0].cloth.material.stretch_stiffness: belongs to springs; a membrane has"},
        Refusal{"bend springs of a membrane", cloth("model: membrane, bending: springs"),
                "s.yaml:4: bodies[0].cloth.bending: a membrane bends by hinges or quadratic"},
        Refusal{"bend springs beside hinges", cloth("material: {bending_rigidity: 1e-5, bend_stiffness: 1}"),
                "s.yaml:4: bodies[0].cloth.material.bend_stiffness: belongs to bending: springs"},
        Refusal{"rigidity of bend springs", cloth("bending: springs, material: {bending_rigidity: 1e-5}"),
                "s.yaml:4: bodies[0].cloth.material.bending_rigidity: belongs to bending: hinges or quadratic"},
        Refusal{"hinges without rigidity", cloth("bending: hinges"),
                "s.yaml:4: bodies[0].cloth.bending: needs material.bending_rigidity"},
        Refusal{"orthotropic rubber",
                cloth("model: membrane, law: neo_hookean, material: {membrane_stiffness: [100, 200]}"),
                "s.yaml:4: bodies[0].cloth.law: neo_hookean is isotropic"},
        Refusal{"three for a pair", cloth("model: membrane, material: {bending_rigidity: [1, 2, 3]}"),
                "s.yaml:4: bodies[0].cloth.material.bending_rigidity: must be a list of 2 numbers, not of 3"},
        Refusal{"zero rigidity", cloth("material: {bending_rigidity: 0}"),
                "s.yaml:4: bodies[0].cloth.material.bending_rigidity: 0 is out of range; allowed: > 0"},
        Refusal{"impossible ratio",
                cloth("model: membrane, material: {membrane_stiffness: [10, 1000], poissons_ratio: 0.4}"),
                "s.yaml:2: bodies[0]: "},
        Refusal{"elastic limit", cloth("material: {elastic_limit: -1}"),
                "s.yaml:4: bodies[0].cloth.material.elastic_limit: -1 is out of range"}));

INSTANTIATE_TEST_SUITE_P(
    Rope, ModelRefusals,
    testing::Values(
        Refusal{"model", rope("model: beam"),
                "s.yaml:4: bodies[0].rope.model: unknown 'beam'; allowed: springs, untwisted, rod"},
        Refusal{"curved springs", rope("natural_curvature: 3"),
                "s.yaml:4: bodies[0].rope.natural_curvature: belongs to model: rod"},
        Refusal{"twisted springs", rope("natural_twist: 3"),
                "s.yaml:4: bodies[0].rope.natural_twist: belongs to model: rod"},
        Refusal{"start of springs", rope("start: straight"), "s.yaml:4: bodies[0].rope.start: belongs to model: rod"},
        Refusal{"start", rope("model: rod, start: bent"), "s.yaml:4: bodies[0].rope.start: unknown 'bent'"},
        Refusal{"rigidity of springs", rope("material: {bending_rigidity: 1}"),
                "s.yaml:4: bodies[0].rope.material.bending_rigidity: belongs to model: untwisted or rod"},
        Refusal{"twist of springs", rope("material: {twist_rigidity: 1}"),
                "s.yaml:4: bodies[0].rope.material.twist_rigidity: belongs to model: rod"},
        Refusal{"section of springs", rope("material: {section: [0.01, 0.001]}"),
                "s.yaml:4: bodies[0].rope.material.section: belongs to model: rod"},
        Refusal{"springs of a rod", rope("model: rod, material: {bend_stiffness: 1}"),
                "s.yaml:4: bodies[0].rope.material.bend_stiffness: belongs to model: springs"},
        Refusal{"section and diameter", rope("model: rod, material: {section: [0.01, 0.001], diameter: 0.01}"),
                "s.yaml:4: bodies[0].rope.material.section: excludes diameter"},
        Refusal{"one for a section", rope("model: rod, material: {section: 0.01}"),
                "s.yaml:4: bodies[0].rope.material.section: must be a list of 2 numbers"},
        Refusal{"tight curl", rope("model: rod, natural_curvature: 100"),
                "s.yaml:2: bodies[0].rope: the rod's rest curvature must be less than 3 rad a joint"},
        Refusal{"wild curvature", rope("model: rod, natural_curvature: 1e5"),
                "s.yaml:4: bodies[0].rope.natural_curvature: 1e5 is out of range; allowed: -1000 ... 1000"},
        Refusal{"unknown name", rope("material: nylon_roap"), "s.yaml:4: bodies[0].rope.material: "}));

INSTANTIATE_TEST_SUITE_P(
    Soft, ModelRefusals,
    testing::Values(
        Refusal{"no shape", "bodies:\n  - soft: {name: a}\n",
                "s.yaml:2: bodies[0].soft: needs exactly one of box, mesh"},
        Refusal{"box and mesh", soft("mesh: a.msh"), "s.yaml:3: bodies[0].soft: needs exactly one of box, mesh"},
        Refusal{"box without size", "bodies:\n  - soft: {name: a, box: {cells: [1, 1, 1]}}\n",
                "s.yaml:2: bodies[0].soft.box.size: required, and missing"},
        Refusal{"flat box", "bodies:\n  - soft: {name: a, box: {size: [1, 1, 0]}}\n",
                "s.yaml:2: bodies[0].soft.box.size[2]: 0 is out of range; allowed: 0.001 ... 100"},
        Refusal{"two cells", "bodies:\n  - soft: {name: a, box: {size: [1, 1, 1], cells: [2, 2]}}\n",
                "s.yaml:2: bodies[0].soft.box.cells: must be a list of 3 whole numbers, not of 2"},
        Refusal{"no cell", "bodies:\n  - soft: {name: a, box: {size: [1, 1, 1], cells: [2, 2, 0]}}\n",
                "s.yaml:2: bodies[0].soft.box.cells[2]: 0 is out of range; allowed: 1 ... 1000"},
        Refusal{"too many nodes",
                "bodies:\n  - soft: {name: a, element: tetrahedron, box: {size: [1, 1, 1], cells: [60, 60, 60]}}\n",
                "s.yaml:2: bodies[0].soft: 226981 nodes so far; at most 200000 in a scene"},
        Refusal{"too many middle nodes",
                "bodies:\n  - soft: {name: a, element: quadratic_tetrahedron, box: {size: [1, 1, 1], cells: [30, 30, "
                "30]}}\n",
                "s.yaml:2: bodies[0].soft: 226981 nodes so far; at most 200000 in a scene"},
        Refusal{"element", soft("element: hexahedron"), "s.yaml:4: bodies[0].soft.element: unknown 'hexahedron'"},
        Refusal{"law", soft("law: hook"), "s.yaml:4: bodies[0].soft.law: unknown 'hook'; did you mean 'hooke'?"},
        Refusal{"rubber that gives way", soft("law: neo_hookean, material: {poissons_ratio: -0.1}"),
                "s.yaml:4: bodies[0].soft.material.poissons_ratio: law neo_hookean needs 0 or more"},
        Refusal{"law of springs", soft("element: springs, law: hooke"),
                "s.yaml:4: bodies[0].soft.law: belongs to tetrahedra; springs are linear"},
        Refusal{"mass", soft("mass: heavy"),
                "s.yaml:4: bodies[0].soft.mass: unknown 'heavy'; allowed: lumped, consistent"},
        Refusal{"mass of springs", soft("element: springs, mass: consistent"),
                "s.yaml:4: bodies[0].soft.mass: belongs to tetrahedra"},
        Refusal{"initial twist of springs", rope("initial_twist: 1"),
                "s.yaml:4: bodies[0].rope.initial_twist: belongs to model: rod"},
        Refusal{"initial twist of a loop", rope("model: rod, closed: true, initial_twist: 1"),
                "s.yaml:4: bodies[0].rope.initial_twist: belongs to an open rod"},
        Refusal{"neighbours", soft("element: springs, neighbours: 8"),
                "s.yaml:4: bodies[0].soft.neighbours: 8 is out of range; allowed: 6, 18, 26"},
        Refusal{"neighbours of tetrahedra", soft("neighbours: 6"),
                "s.yaml:4: bodies[0].soft.neighbours: belongs to element: springs"},
        Refusal{"lattice of a box", soft("lattice: {cell: 0.1}"), "s.yaml:4: bodies[0].soft.lattice: belongs to mesh"},
        Refusal{"incompressible", soft("material: {poissons_ratio: 0.5}"),
                "s.yaml:4: bodies[0].soft.material.poissons_ratio: 0.5 is out of range; allowed: -0.99 ... 0.499"},
        Refusal{"no density", soft("material: {density: 0}"),
                "s.yaml:4: bodies[0].soft.material.density: 0 is out of range"},
        Refusal{"no modulus", soft("material: {youngs_modulus: -1}"),
                "s.yaml:4: bodies[0].soft.material.youngs_modulus: -1 is out of range"},
        Refusal{"share", soft("material: {mooney_rivlin_share: 2}"),
                "s.yaml:4: bodies[0].soft.material.mooney_rivlin_share: 2 is out of range"},
        Refusal{"name of another kind", soft("material: cotton_voile"), "s.yaml:4: bodies[0].soft.material: "},
        Refusal{"unknown feature", soft("pins: [face_x2]"),
                "s.yaml:4: bodies[0].soft.pins[0]: 'a' has no feature 'face_x2'; it has face_x0, face_x1"},
        Refusal{"pins that share a node", soft("pins: [face_x0, corner_0]"),
                "s.yaml:4: bodies[0].soft.pins: node 0 of 'a' is already held by 'pin_a_face_x0'"},
        Refusal{"elongated cells of springs",
                "bodies:\n  - soft: {name: a, element: springs, box: {size: [1, 0.1, 0.1], cells: [1, 4, 4]}}\n",
                "s.yaml:2: bodies[0]: "}));

INSTANTIATE_TEST_SUITE_P(
    SoftMesh, ModelRefusals,
    testing::Values(
        Refusal{"missing", "bodies:\n  - soft:\n      name: a\n      mesh: nowhere.msh\n",
                "s.yaml:4: bodies[0].soft.mesh: nowhere.msh: no such mesh file"},
        Refusal{"surface without lattice",
                "bodies:\n  - soft:\n      name: a\n      mesh: " + mesh_path("meshes/soft_toy.obj") + "\n",
                "s.yaml:4: bodies[0].soft.mesh: a surface needs lattice: {cell: METRES}"},
        Refusal{"lattice of tetrahedra", "bodies:\n  - soft: {name: a, mesh: a.msh, lattice: {cell: 0.1}}\n",
                "s.yaml:2: bodies[0].soft.lattice: belongs to a mesh that is a surface"},
        Refusal{"springs of tetrahedra", "bodies:\n  - soft: {name: a, mesh: a.msh, element: springs}\n",
                "s.yaml:2: bodies[0].soft.element: springs need the cells of a box or a lattice"},
        Refusal{"open surface",
                "bodies:\n  - soft: {name: a, mesh: " + mesh_path("meshes/tshirt.obj") + ", lattice: {cell: 0.05}}\n",
                "s.yaml:2: bodies[0].soft.mesh: "},
        Refusal{"fine lattice",
                "bodies:\n  - soft: {name: a, mesh: " + mesh_path("meshes/soft_toy.obj") + ", lattice: {cell: 1e-5}}\n",
                "s.yaml:2: bodies[0].soft.mesh: lattice.cell: "},
        Refusal{"no cell",
                "bodies:\n  - soft: {name: a, mesh: " + mesh_path("meshes/soft_toy.obj") + ", lattice: {cell: 0}}\n",
                "s.yaml:2: bodies[0].soft.lattice.cell: 0 is out of range"}));

INSTANTIATE_TEST_SUITE_P(
    StepAndOutputs, ModelRefusals,
    testing::Values(Refusal{"jacobian", cloth("friction: 1") + "step: {jacobian: exact}\n",
                            "s.yaml:5: step.jacobian: unknown 'exact'; allowed: projected, lagged, axial"},
                    Refusal{"color by stress of none", cloth("friction: 1") + "outputs: {color_by: stres}\n",
                            "s.yaml:5: outputs.color_by: unknown 'stres'; did you mean 'stress'?"},
                    Refusal{"stress range", cloth("friction: 1") + "outputs: {stress_range: 0}\n",
                            "s.yaml:5: outputs.stress_range: 0 is out of range"},
                    // 0 as a float, which no strain can be divided by.
                    Refusal{"strain range", cloth("friction: 1") + "outputs: {strain_range: 5.0e-324}\n",
                            "s.yaml:5: outputs.strain_range: 5.0e-324 is out of range"},
                    Refusal{"frames", cloth("friction: 1") + "outputs: {frames: 1}\n",
                            "s.yaml:5: outputs.frames: must be true or false"}));

}  // namespace
}  // namespace deformable_sim
