"""The Markdown pages of this package: their links, their headings, and the snippets that tests run.

A snippet is a fenced block with a language, or an indented block that begins with a command. Lines of their own directly
before it say more (empty lines between do not count):

  <!-- not run: why -->    it cannot be run in a test
  <!-- file: NAME -->      it is saved as this file for the snippets after it
  <!-- stays -->           its commands run until the page ends
  <!-- with: COMMAND -->   this runs beside it until the page ends, such as what stands in for a robot
"""
import glob
import os
import re
from collections import Counter, namedtuple

RUN = ('sh', 'console', 'yaml', 'xml', 'python')
COMMANDS = ('./run', 'ros', 'cmake', 'python3', 'source')
PATH = re.compile(r'`((?:bench|config|doc|examples|launch|meshes|scripts|test|urdf)/[\w./-]+)`')

# not_run: why, file: its name, beside: a command; or None.
Snippet = namedtuple('Snippet', 'page line language text not_run file stays beside')


def pages(root):
    """README, CONTRIBUTING and all of doc/, relative to `root`."""
    found = [os.path.relpath(path, root) for path in glob.glob(os.path.join(root, 'doc', '**', '*.md'), recursive=True)]
    return [page for page in ('README.md', 'CONTRIBUTING.md') if os.path.exists(os.path.join(root, page))] + sorted(found)


def read(root, page):
    with open(os.path.join(root, page), encoding='utf-8') as stream:
        return stream.read()


def prose(text):
    """(line number, line) of what is not in a fenced block."""
    fenced = False
    for number, line in enumerate(text.splitlines(), 1):
        if line.lstrip().startswith('```'):
            fenced = not fenced
        elif not fenced:
            yield number, line


def anchors(text):
    """What a link to a heading of this page may be called: as GitHub makes it."""
    seen = Counter()
    found = set()
    for _, line in prose(text):
        heading = re.match(r'#{1,6} +(.*?)\s*$', line)
        if heading:
            plain = re.sub(r'\[([^]]*)\]\([^)]*\)', r'\1', heading.group(1)).lower()
            slug = re.sub(r'[^\w\- ]', '', plain).replace(' ', '-')
            found.add(slug if not seen[slug] else '%s-%d' % (slug, seen[slug]))
            seen[slug] += 1
    return found


def broken_links(root, page):
    """One line for each link, and each path in backticks, that leads nowhere. Addresses of the web are left alone."""
    problems = []
    text = read(root, page)
    for number, line in prose(text):
        if line.startswith('    '):
            continue
        for path in PATH.findall(line):
            if not os.path.exists(os.path.join(root, path.rstrip('.'))):
                problems.append('%s:%d: no file %s' % (page, number, path))
        for target in re.findall(r'\]\(([^)\s]+)\)', re.sub(r'`[^`]*`', '', line)):
            if re.match(r'[a-z]+:', target):
                continue
            path, _, anchor = target.partition('#')
            found = os.path.normpath(os.path.join(os.path.dirname(page), path)) if path else page
            if not os.path.exists(os.path.join(root, found)):
                problems.append('%s:%d: no file %s' % (page, number, target))
            elif anchor and anchor not in anchors(read(root, found)):
                problems.append('%s:%d: no heading #%s in %s' % (page, number, anchor, found))
    return problems


def snippets(root, page):
    """All of them, in their order; those with languages that are not run (C++, CMake, text) are left out."""
    found = []
    marks = {}
    lines = read(root, page).splitlines()
    number = 0

    def add(begin, language, block):
        if language in RUN:
            found.append(Snippet(page, begin, language, '\n'.join(block) + '\n', marks.get('not run'), marks.get('file'),
                                 'stays' in marks, marks.get('with')))
        marks.clear()

    while number < len(lines):
        line = lines[number]
        mark = re.match(r'<!-- (not run|file|stays|with)(?:: (.*?))? -->$', line)
        if mark:
            marks[mark.group(1)] = mark.group(2)
        elif line.startswith('```'):
            end = next((i for i in range(number + 1, len(lines)) if lines[i].startswith('```')), len(lines))
            add(number + 1, line[3:].strip(), lines[number + 1:end])
            number = end
        elif line.startswith('    ') and (number == 0 or not lines[number - 1].strip()):
            end = next((i for i in range(number, len(lines)) if not lines[i].startswith('    ')), len(lines))
            if line.strip().startswith(COMMANDS):
                add(number + 1, 'sh', [text[4:] for text in lines[number:end]])
            marks.clear()
            number = end - 1
        elif line.strip():
            marks.clear()
        number += 1
    return found
