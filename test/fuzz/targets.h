// What one hostile input goes through, for the fuzzers and for the test that replays what they found.
#pragma once

#include <string>

namespace deformable_sim {
namespace fuzz {

// All return when the input was read, or refused with an InputError of one readable line. Whatever else happens is a
// failure: another exception, std::logic_error for a state that is not finite, a crash, what sanitizers see.

/// A scene text: loaded; built and stepped twice when it is small.
void try_scene(const std::string& text);

/// A file of triangles or tetrahedra: the first line names the format (obj, stl, ply, dae, msh, mesh, tetgen), the rest
/// is the file. Of tetgen it is the two files, .node and .ele, with a line `%%` between them. Small closed surfaces
/// become colliders.
void try_mesh(const std::string& bytes);

/// An octomap file (.bt or .ot).
void try_octomap(const std::string& bytes);

/// Three material files, solids, fabrics and ropes, with lines `%%` between them.
void try_materials(const std::string& text);

}  // namespace fuzz
}  // namespace deformable_sim
