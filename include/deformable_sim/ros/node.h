// The node: reads parameters, loads the scene, wires topics and services to the simulation.
#pragma once

namespace deformable_sim {

/// Runs until shutdown. Returns the exit code: 0; 2 when parameters or scene were refused; 1 after any other error.
int run_node(int argc, char** argv);

}  // namespace deformable_sim
