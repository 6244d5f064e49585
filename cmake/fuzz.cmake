# libFuzzer programs, run by ./run study fuzz_files; built by the target fuzz_programs only.
foreach(level sse2 avx2 avx512)
  set_property(SOURCE src/core/grid/sheet_kernels_${level}.cpp APPEND PROPERTY COMPILE_OPTIONS
    -include ${CMAKE_CURRENT_SOURCE_DIR}/test/fuzz/gcc_vectors.h)
endforeach()
add_library(fuzz_targets STATIC EXCLUDE_FROM_ALL test/fuzz/targets.cpp test/fuzz/yaml_mutator.cpp)
target_include_directories(fuzz_targets PUBLIC test)
target_compile_definitions(fuzz_targets PRIVATE DEFORMABLE_SIM_SOURCE_DIR="${CMAKE_CURRENT_SOURCE_DIR}")
target_link_libraries(fuzz_targets PUBLIC ${PROJECT_NAME}_scene)
set(FUZZ_PROGRAMS)
foreach(kind scene mesh octomap material)
  add_executable(${kind}_fuzzer EXCLUDE_FROM_ALL test/fuzz/${kind}_fuzzer.cpp)
  target_link_libraries(${kind}_fuzzer PRIVATE fuzz_targets)
  target_link_options(${kind}_fuzzer PRIVATE -fsanitize=fuzzer)
  list(APPEND FUZZ_PROGRAMS ${kind}_fuzzer)
endforeach()
# The words that mutations draw from, one a line: the dictionary of the scene fuzzer is made of them.
add_executable(fuzz_words EXCLUDE_FROM_ALL test/fuzz/words.cpp)
target_link_libraries(fuzz_words PRIVATE fuzz_targets)
add_custom_target(fuzz_programs DEPENDS ${FUZZ_PROGRAMS} fuzz_words)
# rosrun looks for programs by their names in the whole checkout, and is to find one node.
if(TARGET sim_node)
  set_target_properties(sim_node PROPERTIES OUTPUT_NAME watched_sim_node)
endif()
