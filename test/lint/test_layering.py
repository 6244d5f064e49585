"""The layering lint is seen failing: every rule against the smallest tree that breaks it."""
import os
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import layering  # noqa: E402

# path, text, part of the refusal
BAD = [
    ('src/core/world.cpp', '#include <ros/ros.h>', 'core may not include <ros/ros.h>'),
    ('src/core/world.cpp', '#include <tf2/LinearMath/Vector3.h>', 'core may not include'),
    ('include/deformable_sim/core/model.h', '#include <geometry_msgs/Point.h>', 'core may not include'),
    ('src/core/world.cpp', '#include <yaml-cpp/yaml.h>', 'YAML is read in scene only'),
    ('src/core/world.cpp', '#include <fcl/fcl.h>', 'FCL is included in core/contact only'),
    ('src/core/grid/x.cpp', '#include <tbb/parallel_for.h>', 'threads are made in core/parallel only'),
    ('src/scene/build.cpp', '#include <fcl/fcl.h>', 'FCL is included in core/contact only'),
    ('src/ros/node.cpp', '#include <fcl/fcl.h>', 'FCL is included in core/contact only'),
    ('src/ros/node.cpp', '#include <yaml-cpp/yaml.h>', 'YAML is read in scene only'),
    ('src/scene/load.cpp', '#include <ros/console.h>', 'scene may not include'),
    ('src/core/world.cpp', '#include "deformable_sim/scene/spec.h"', 'core may include nothing of scene'),
    ('src/core/world.cpp', '#include "deformable_sim/BodyState.h"', 'core may include nothing of ros'),
    ('src/scene/build.cpp', '#include "deformable_sim/ros/node.h"', 'scene may include only core and scene'),
    ('src/scene/load.cpp', '#include "deformable_sim/core/energy/terms.h"', 'turn a name into a type'),
    ('src/simulate.cpp', '#include <ros/ros.h>', 'program may not include'),
    ('src/simulate.cpp', '#include "deformable_sim/ros/node.h"', 'headless programs'),
    ('src/study/report.cpp', '#include <ros/ros.h>', 'study may not include'),
    ('src/study/report.cpp', '#include <yaml-cpp/yaml.h>', 'YAML is read in scene only'),
    ('src/study/report.cpp', '#include "deformable_sim/ros/node.h"', 'headless programs'),
    ('src/robot/demo.cpp', '#include "deformable_sim/core/world.h"', 'public ROS interface'),
    ('src/rviz/plot.cpp', '#include "deformable_sim/ros/frames.h"', 'public ROS interface'),
    ('src/core/element/spring.cpp', '#include "deformable_sim/core/energy/energy.h"', 'core/element/spring.cpp may'),
    ('src/core/element/spring.cpp', '#include "deformable_sim/core/world.h"', 'core/element/spring.cpp may'),
    ('src/core/element/spring.cpp', '#include "deformable_sim/core/integrator/integrator.h"', 'core/element/spring.cpp'),
    ('src/core/integrator/rk4.cpp', '#include "deformable_sim/core/element/spring.h"', 'core/integrator/rk4.cpp may'),
    ('src/core/integrator/rk4.cpp', '#include "deformable_sim/core/world.h"', 'core/integrator/rk4.cpp may'),
    ('src/core/energy/springs.cpp', '#include "deformable_sim/core/integrator/integrator.h"', 'core/energy/springs.cpp'),
    ('src/core/contact/x.cpp', '#include "deformable_sim/core/integrator/integrator.h"', 'core/contact/x.cpp may'),
    ('src/core/grid/rows.cpp', '#include <immintrin.h>', 'intrinsics belong to the kernels'),
    ('src/core/grid/rows.cpp', '#include "deformable_sim/core/energy/energy.h"', 'core/grid/rows.cpp may'),
    ('src/core/world.cpp', 'void f() {\n  static int calls = 0;\n}', ':2: static mutable data'),
    ('src/core/world.cpp', 'void f() {\n  static std::vector<int> cache;\n}', ':2: static mutable data'),
    ('src/core/world.cpp', 'void f() {\n  thread_local double scratch[3];\n}', ':2: static mutable data'),
    ('src/core/world.cpp', 'namespace {\nint counter = 0;\n}', ':2: mutable data at namespace scope'),
    ('src/core/world.cpp', 'std::map<std::string, int> table;', ':1: mutable data at namespace scope'),
    ('src/ros/node.cpp', 'Node* instance = nullptr;', ':1: mutable data at namespace scope'),
]

GOOD = [
    ('src/core/grid/sheet_kernels_avx2.cpp', '#include <immintrin.h>'),
    ('src/simulate.cpp', 'volatile std::sig_atomic_t g_interrupted = 0;'),
    ('src/core/contact/x.cpp', '#include <fcl/fcl.h>\n#include <Eigen/Core>\n#include <vector>'),
    ('src/scene/load.cpp', '#include <yaml-cpp/yaml.h>\n#include "deformable_sim/core/error.h"'),
    ('src/scene/build.cpp', '#include "deformable_sim/core/energy/terms.h"'),
    ('src/ros/node.cpp', '#include <ros/ros.h>\n#include "deformable_sim/scene/build.h"\n#include "deformable_sim/Step.h"'),
    ('src/robot/demo.cpp', '#include <ros/ros.h>\n#include "deformable_sim/Grasp.h"'),
    ('src/rviz/plot.cpp', '#include <QWidget>\n#include "deformable_sim/Step.h"\n#include "deformable_sim/rviz/plot.h"'),
    ('src/core/integrator/rk4.cpp', '#include "deformable_sim/core/energy/energy.h"'),
    ('src/scene/x.cpp', 'const char kPage[] = R"(\nyields, breaks or leaves its range; a body\n// static\n)";'),
    ('src/core/world.cpp', '// static int calls = 0;\nconstexpr int kThree = 3;\nconst char* const kName = "static int a;";'),
    ('src/core/world.cpp', 'double f(int a);\nclass World::Part;\nstruct A {\n  static A make();\n  static constexpr int kN = 1;\n};'),
    ('src/core/world.cpp', 'Mat3 outer(const Vec3& a,\n           const Vec3& b) {\n  static const Mat3 zero = Mat3::Zero();\n}'),
]


class Layering(unittest.TestCase):
    def check(self, path, text):
        with tempfile.TemporaryDirectory() as root:
            full = os.path.join(root, path)
            os.makedirs(os.path.dirname(full))
            with open(full, 'w', encoding='utf-8') as stream:
                stream.write(text + '\n')
            return layering.check_tree(root)

    def test_refuses_every_way_across_a_layer(self):
        for path, text, message in BAD:
            with self.subTest(path=path, text=text):
                problems = self.check(path, text)
                self.assertEqual(len(problems), 1, problems)
                self.assertIn(message, problems[0])

    def test_a_header_beside_the_file_counts_as_its_own_layer(self):
        with tempfile.TemporaryDirectory() as root:
            for path, text in (('src/core/element/a.cpp', '#include "../world_parts.h"\n#include "b.h"'),
                               ('src/core/element/b.h', ''), ('src/core/world_parts.h', '')):
                full = os.path.join(root, path)
                os.makedirs(os.path.dirname(full), exist_ok=True)
                with open(full, 'w', encoding='utf-8') as stream:
                    stream.write(text)
            problems = layering.check_tree(root)
            self.assertEqual(len(problems), 1, problems)
            self.assertIn('src/core/element/a.cpp:1:', problems[0])

    def test_the_bench_may_use_its_own_files_and_no_other_program_may(self):
        with tempfile.TemporaryDirectory() as root:
            os.makedirs(os.path.join(root, 'src/study'))
            for path, text in (('src/study.cpp', '#include "study/bench.h"'), ('src/simulate.cpp', '#include "study/bench.h"'),
                               ('src/study/bench.cpp', '#include "bench.h"'),
                               ('src/study/bench.h', '#include <Eigen/Core>\n#include "deformable_sim/core/model.h"')):
                with open(os.path.join(root, path), 'w', encoding='utf-8') as stream:
                    stream.write(text + '\n')
            problems = layering.check_tree(root)
            self.assertEqual(len(problems), 1, problems)
            self.assertIn('src/simulate.cpp:1: headless programs', problems[0])

    def test_accepts_what_the_layers_allow(self):
        for path, text in GOOD:
            with self.subTest(path=path, text=text):
                self.assertEqual(self.check(path, text), [])


if __name__ == '__main__':
    unittest.main()
