#!/usr/bin/env python3
"""Links of the documentation lead somewhere, and the check of them sees where they do not."""
import os
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.path.insert(0, os.path.join(ROOT, 'test', 'lint'))

import documents  # noqa: E402

PAGE = """# A page: of `two` words

[there](other.md), [here](#a-page-of-two-words), [web](https://example.org/x), `[not](a_link)`, `doc/other.md`.

```sh
ls [not](a_link)
```

<!-- not run: no robot -->

```yaml
bodies: []
```

    rosrun a b   # indented
    rosrun a c

    formula = [x](y)

<!-- file: mine.py -->
```python
print()
```

```cpp
int i;
```
"""


class Documents(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = folder.name
        os.mkdir(os.path.join(self.root, 'doc'))
        self.write('page.md', PAGE)
        self.write('other.md', '## Twice\n\n## Twice\n')

    def write(self, name, text):
        with open(os.path.join(self.root, 'doc', name), 'w', encoding='utf-8') as stream:
            stream.write(text)

    def broken(self, text):
        self.write('page.md', text)
        return documents.broken_links(self.root, 'doc/page.md')

    def test_every_link_of_the_documentation_leads_somewhere(self):
        found = documents.pages(ROOT)
        self.assertGreater(len(found), 20)
        problems = [problem for page in found for problem in documents.broken_links(ROOT, page)]
        self.assertEqual(problems, [], '\n'.join([''] + problems))

    def test_links_that_lead_somewhere_are_let_through(self):
        self.assertEqual(documents.broken_links(self.root, 'doc/page.md'), [])
        self.assertEqual(self.broken('[a](other.md#twice) [b](other.md#twice-1)'), [])

    def test_a_missing_file_is_found(self):
        self.assertEqual(self.broken('one\n[a](gone.md)'), ['doc/page.md:2: no file gone.md'])

    def test_a_missing_heading_is_found(self):
        self.assertEqual(self.broken('[a](other.md#thrice)'), ['doc/page.md:1: no heading #thrice in doc/other.md'])
        self.assertEqual(self.broken('[a](#gone)'), ['doc/page.md:1: no heading #gone in doc/page.md'])

    def test_a_missing_path_in_backticks_is_found(self):
        self.assertEqual(self.broken('`config/gone.yaml`'), ['doc/page.md:1: no file config/gone.yaml'])

    def test_snippets_have_their_language_and_marks(self):
        found = documents.snippets(self.root, 'doc/page.md')
        self.assertEqual([(s.line, s.language, s.not_run, s.file) for s in found],
                         [(5, 'sh', None, None), (11, 'yaml', 'no robot', None), (15, 'sh', None, None),
                          (21, 'python', None, 'mine.py')])
        self.assertEqual(found[2].text, 'rosrun a b   # indented\nrosrun a c\n')


if __name__ == '__main__':
    unittest.main()
