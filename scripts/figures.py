"""Pages that hold their figures: HTML in one file, figures as SVG by matplotlib where it is installed."""
import html
import io

STYLE = '''<style>
body { font: 15px/1.5 sans-serif; max-width: 72em; margin: 2em auto; padding: 0 1em; color: #222; }
table { border-collapse: collapse; margin: 1em 0; } th { text-align: left; }
th, td { border-bottom: 1px solid #ddd; padding: 2px 10px; vertical-align: top; }
td.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
.bad { color: #b00020; font-weight: bold; } .gap { color: #8a5a00; } .low { color: #999; } svg { max-width: 100%; height: auto; }
</style>'''


def pyplot():
    """matplotlib.pyplot without a display, or None where it is not installed."""
    try:
        import matplotlib
    except ImportError:
        return None
    matplotlib.use('svg')
    matplotlib.rcParams.update({'svg.fonttype': 'none', 'axes.grid': True, 'grid.alpha': 0.3, 'font.size': 9})
    import matplotlib.pyplot
    return matplotlib.pyplot


def svg(figure):
    """The figure as SVG text, closed."""
    stream = io.StringIO()
    figure.savefig(stream, format='svg', bbox_inches='tight')
    pyplot().close(figure)
    text = stream.getvalue()
    return text[text.index('<svg'):]


def number(value, digits=5):
    return '' if value is None else '%.*g' % (digits, value)


def cell(value, kind=''):
    return '<td%s>%s</td>' % (' class="%s"' % kind if kind else '', html.escape(str(value)))


def table(headings, rows):
    """rows: lists of (text, class)."""
    head = ''.join('<th>%s</th>' % html.escape(h) for h in headings)
    body = ''.join('<tr>%s</tr>\n' % ''.join(cell(text, kind) for text, kind in row) for row in rows)
    return '<table><tr>%s</tr>\n%s</table>\n' % (head, body)


def page(title, body):
    return '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>%s</title>%s</head>\n<body><h1>%s</h1>\n%s' \
           '</body></html>\n' % (html.escape(title), STYLE, html.escape(title), body)
