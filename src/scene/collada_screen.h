// What a Collada file is asked before a general XML and Collada reader sees it.
#pragma once

#include <string>

namespace deformable_sim {

/// Refuses text that makes a reader take memory or stack beyond what its size gives a right to: elements nested deeper
/// than 100, a `count` of more values than the file has bytes, `instance_node`, by which a few lines stand for
/// millions of nodes, or for themselves, and text among indices. Throws InputError. Not a check of whether it is
/// Collada.
void screen_collada(const std::string& text);

}  // namespace deformable_sim
