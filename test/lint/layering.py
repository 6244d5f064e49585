#!/usr/bin/env python3
"""Layering lint: who may include what, and no mutable static data.

Debian puts ROS headers in the default include path, so neither compiler nor linker protects the layers. The rules are
allow-lists: a header that no rule names is refused. Usage: layering.py [ROOT]; one line a violation, exit status 1.
"""
import os
import re
import sys

STANDARD = re.compile(r'[a-z0-9_]+$')  # <vector>, <cmath>: no slash, no dot
C_HEADERS = {'time.h', 'pthread.h', 'unistd.h', 'sys/stat.h', 'sys/types.h', 'signal.h'}
PROCESS_HEADERS = {'sys/resource.h', 'sys/wait.h'}  # of studies that run a case in a process of its own
SYSTEM_HEADERS = (('core', 'whole_file.cpp', 'fcntl.h'), ('scene', 'scene_files.cpp', 'dlfcn.h'))
PACKAGE = 'deformable_sim/'

# Folder or file of core -> what of core it may include. Longest match wins. None = all of core.
CORE_RULES = {
    'types.h': [],
    'simd_level.h': [],
    'error.h': [],
    'state.h': ['types.h'],
    'archive': ['types.h', 'error.h', 'archive.h', 'frame_motion.h'],
    'whole_file': ['error.h', 'whole_file.h'],
    'frame_motion': ['types.h', 'error.h', 'archive.h', 'frame_motion.h'],
    'element/': ['types.h', 'error.h', 'element/', 'material/'],
    'material/': ['types.h', 'error.h', 'material/', 'topology/'],
    'topology/': ['types.h', 'error.h', 'topology/'],
    'parallel/': ['error.h', 'parallel/'],
    'linear/': ['types.h', 'error.h', 'simd_level.h', 'parallel/', 'linear/'],
    'rod_frames': ['types.h', 'error.h', 'state.h', 'element/rod_frame.h', 'topology/', 'model.h', 'rod_frames.h'],
    'energy/': ['types.h', 'error.h', 'state.h', 'element/', 'material/', 'topology/', 'linear/', 'rod_frames.h', 'energy/'],
    'rope/': ['types.h', 'element/spring.h', 'energy/', 'simd_level.h', 'rope/'],
    'grid/': ['types.h', 'error.h', 'simd_level.h', 'element/jacobian.h', 'linear/', 'material/', 'parallel/', 'topology/', 'grid/'],
    'integrator/': ['types.h', 'error.h', 'state.h', 'linear/', 'parallel/', 'element/jacobian.h', 'energy/energy.h', 'energy/terms.h', 'energy/limit_springs.h',
                    'energy/known_terms.h', 'contact/constraint.h', 'contact/stick.h', 'grasp/kinematics.h', 'grid/', 'rope/', 'integrator/'],
    'contact/': ['types.h', 'error.h', 'state.h', 'archive.h', 'whole_file.h', 'frame_motion.h', 'parallel/', 'topology/', 'model.h', 'contact/'],
    'grasp/': ['types.h', 'error.h', 'state.h', 'archive.h', 'frame_motion.h', 'element/rod_frame.h', 'rod_frames.h', 'topology/',
               'model.h', 'energy/', 'grasp/'],
    'model': ['types.h', 'error.h', 'state.h', 'energy/', 'grid/', 'material/', 'topology/', 'model.h'],
    '': None,
}


def layer_of(path):
    """('core', 'element/x.h') for include/deformable_sim/core/element/x.h or src/core/element/x.h."""
    for prefix in ('include/deformable_sim/', 'src/'):
        if path.startswith(prefix):
            layer, _, rest = path[len(prefix):].partition('/')
            return (layer, rest) if rest else ('program', layer)
    return None, path


def matches(name, allowed):
    return any(name == a or (a.endswith('/') and name.startswith(a)) for a in allowed)


def core_allowance(rest):
    best = max((key for key in CORE_RULES if rest.startswith(key)), key=len)
    return CORE_RULES[best]


def check_package_include(layer, rest, target_layer, target):
    """Why a file of `layer` may not include deformable_sim/<target_layer>/<target>, or None."""
    if layer == 'core':
        if target_layer != 'core':
            return 'core may include nothing of %s' % target_layer
        allowed = core_allowance(rest)
        if allowed is not None and not matches(target, allowed):
            return 'core/%s may include of core only: %s' % (rest, ', '.join(allowed) or 'nothing')
    elif layer == 'scene':
        if target_layer not in ('core', 'scene'):
            return 'scene may include only core and scene'
        if target_layer == 'core' and target.startswith(('energy/', 'element/')) \
                and not rest.startswith(('build', 'registry')):
            return 'only scene/build and scene/registry turn a name into a type'
    elif layer == 'robot':
        if target_layer in ('core', 'scene', 'ros'):
            return 'the robot demo uses only the public ROS interface'
    elif layer == 'rviz':
        if target_layer != 'rviz':
            return 'the rviz panel uses only the public ROS interface'
    elif layer == 'study' or layer == 'program' and rest.startswith(('simulate', 'study')):
        if target_layer not in ('core', 'scene') and not (target_layer == 'study' and not rest.startswith('simulate')):
            return 'headless programs may include only core and scene'
    return None


def check_foreign_include(layer, rest, header):
    """Why a file may not include a header that is not of this package, or None."""
    if header.startswith('fcl/') and not (layer == 'core' and rest.startswith('contact/')):
        return 'FCL is included in core/contact only'
    if header.startswith('tbb/'):
        return None if layer == 'core' and rest.startswith('parallel/') else 'threads are made in core/parallel only'
    if header.startswith('yaml-cpp/') and layer not in ('scene', 'robot'):
        return 'YAML is read in scene only'
    if layer in ('ros', 'replay', 'robot', 'rviz') or (layer == 'program' and not rest.startswith(('simulate', 'study'))):
        return None
    if header.endswith('intrin.h'):
        kernels = layer == 'core' and rest.startswith(('grid/sheet_kernels_', 'rope/rope_kernels_'))
        return None if kernels else 'processor intrinsics belong to the kernels of core/grid and core/rope'
    if STANDARD.match(header) or header in C_HEADERS or header.startswith(('Eigen/', 'fcl/')):
        return None
    if layer == 'scene' and header.startswith(('yaml-cpp/', 'assimp/')):
        return None
    if layer == 'study' and header in PROCESS_HEADERS or (layer, rest, header) in SYSTEM_HEADERS:
        return None
    return '%s may not include <%s>' % (layer, header)


def check_includes(path, text, package_root):
    layer, rest = layer_of(path)
    for number, line in enumerate(text.splitlines(), 1):
        found = re.match(r'\s*#\s*include\s*([<"])([^>"]+)[>"]', line)
        if not found:
            continue
        header = found.group(2)
        beside = os.path.normpath(os.path.join(os.path.dirname(path), header))
        if found.group(1) == '"' and not header.startswith(PACKAGE) and os.path.exists(os.path.join(package_root, beside)):
            target_layer, target = layer_of(beside)
            why = check_package_include(layer, rest, target_layer, target)
        elif header.startswith(PACKAGE):
            target_layer, _, target = header[len(PACKAGE):].partition('/')
            if not target:  # generated message header deformable_sim/X.h
                target_layer = 'ros'
                why = None if layer in ('replay', 'robot', 'ros', 'rviz') else check_package_include(layer, rest, 'ros', header)
            else:
                why = check_package_include(layer, rest, target_layer, target)
        else:
            why = check_foreign_include(layer, rest, header)
        if why:
            yield number, why


def without_comments(text):
    """Comments and strings blanked, line numbers kept."""
    def blank(found):
        return re.sub(r'[^\n]', ' ', found.group(0))
    return re.sub(r'R"\((?:.*?)\)"|//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"', blank, text, flags=re.S)


CONSTANT = re.compile(r'\b(const|constexpr|consteval)\b')
NOT_DATA = re.compile(r'(using|typedef|struct|class|enum|union|template|namespace|return|extern|friend|public|private|'
                      r'protected|case|default|goto|static_assert|#|}|\)|operator)')
GLOBAL = re.compile(r'(?:inline\s+|static\s+|thread_local\s+)*[A-Za-z_][\w:<>,\s*&]*?[\s>*&]([A-Za-z_]\w*)(\[[^\]]*\])?\s*(=|;|\{)')


def check_static_data(text):
    """Mutable data that outlives a call: a function's or class's `static`, or a variable at namespace scope.

    Namespaces are not indented here, so a declaration in the first column stands at namespace scope.
    """
    for number, line in enumerate(without_comments(text).splitlines(), 1):
        declared = re.match(r'\s+(?:inline\s+)?(static|thread_local)\s+(.*)', line)
        if declared and not CONSTANT.search(line) and '(' not in declared.group(2).split('=')[0].split('{')[0]:
            yield number, 'static mutable data'
        elif line.startswith('volatile std::sig_atomic_t '):
            continue  # a signal handler can speak through nothing else
        elif line[:1].strip() and not NOT_DATA.match(line) and not CONSTANT.search(line):
            found = GLOBAL.match(line)
            if found and '(' not in line[:found.end()]:
                yield number, 'mutable data at namespace scope'


def check_file(path, text, package_root='.'):
    problems = list(check_includes(path, text, package_root)) + list(check_static_data(text))
    return ['%s:%d: %s' % (path, number, why) for number, why in sorted(problems)]


def check_tree(package_root):
    problems = []
    for top in ('include/deformable_sim', 'src'):
        for folder, _, files in sorted(os.walk(os.path.join(package_root, top))):
            for name in sorted(files):
                if name.endswith(('.h', '.cpp')):
                    full = os.path.join(folder, name)
                    with open(full, encoding='utf-8') as stream:
                        problems += check_file(os.path.relpath(full, package_root), stream.read(), package_root)
    return problems


def main():
    root = sys.argv[1] if len(sys.argv) > 1 else os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..')
    problems = check_tree(root)
    print('\n'.join(problems)) if problems else None
    return 1 if problems else 0


if __name__ == '__main__':
    sys.exit(main())
