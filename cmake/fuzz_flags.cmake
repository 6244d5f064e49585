# Everything with address and undefined-behaviour sanitizers and the coverage that libFuzzer follows. Assertions stay on;
# undefined behaviour ends the process.
if(NOT CMAKE_CXX_COMPILER_ID MATCHES "Clang")
  message(FATAL_ERROR "DEFORMABLE_SIM_FUZZ needs clang: -DCMAKE_CXX_COMPILER=clang++-14")
endif()
set(FUZZ_SANITIZERS address,undefined,float-cast-overflow)
add_compile_options(-O2 -g1 -fno-omit-frame-pointer -fsanitize=fuzzer-no-link,${FUZZ_SANITIZERS}
  -fno-sanitize-recover=undefined,float-cast-overflow)
add_compile_definitions(_GLIBCXX_ASSERTIONS)
add_link_options(-fsanitize=${FUZZ_SANITIZERS})
