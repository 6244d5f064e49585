// Prints the dictionary of the scene fuzzer.
#include <iostream>

#include "fuzz/yaml_mutator.h"

int main() {
  for (const std::string& word : deformable_sim::fuzz::known_words()) std::cout << '"' << word << "\"\n";
  return 0;
}
