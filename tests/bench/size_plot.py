"""Plots of cost against size, with fitted exponents."""
import math

# Okabe & Ito (2008), as in pipeline/charts/plot.hpp
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9"]
FITTED_FROM = {"bodies": 100, "voxels": 1e7}


def fitted_exponent(points, start):
    """The exponent of y = factor x^exponent over the points with x >= start; None for fewer than three."""
    logs = [(math.log(x), math.log(y)) for x, y in points if x >= start]
    if len(logs) < 3:
        return None
    mx = sum(x for x, _ in logs) / len(logs)
    my = sum(y for _, y in logs) / len(logs)
    return sum((x - mx) * (y - my) for x, y in logs) / sum((x - mx) ** 2 for x, _ in logs)


def plot(title, x_label, y_label, curves, start):
    """Curves {name: [(x, y)]} on two logarithmic axes: an SVG and {name: fitted exponent}."""
    width, height, left, right, top, bottom = 760, 460, 80, 290, 40, 60
    xs = [x for points in curves.values() for x, _ in points]
    ys = [y for points in curves.values() for _, y in points]
    low_x, high_x = math.floor(math.log10(min(xs))), math.ceil(math.log10(max(xs)))
    low_y, high_y = math.floor(math.log10(min(ys))), math.ceil(math.log10(max(ys)))

    def at(x, y):
        return (left + (math.log10(x) - low_x) / (high_x - low_x) * (width - left - right),
                height - bottom - (math.log10(y) - low_y) / (high_y - low_y) * (height - top - bottom))

    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" '
           f'font-size="12"><rect width="{width}" height="{height}" fill="white"/>',
           f'<text x="{left}" y="22" font-size="15">{title}</text>']
    for n in range(low_x, high_x + 1):
        x = at(10.0 ** n, 10.0 ** low_y)[0]
        out.append(f'<path d="M{x:.1f} {top}V{height - bottom}" stroke="#ddd"/>'
                   f'<text x="{x:.1f}" y="{height - bottom + 16}" text-anchor="middle">10<tspan dy="-4" '
                   f'font-size="9">{n}</tspan></text>')
    for n in range(low_y, high_y + 1):
        y = at(10.0 ** low_x, 10.0 ** n)[1]
        out.append(f'<path d="M{left} {y:.1f}H{width - right}" stroke="#ddd"/><text x="{left - 8}" y="{y + 4:.1f}" '
                   f'text-anchor="end">10<tspan dy="-4" font-size="9">{n}</tspan></text>')
    out.append(f'<text x="{(left + width - right) / 2}" y="{height - 16}" text-anchor="middle">{x_label}</text>'
               f'<text transform="translate(22 {(top + height - bottom) / 2}) rotate(-90)" '
               f'text-anchor="middle">{y_label}</text>')
    exponents = {}
    kinds = sorted({name.split(",")[0] for name in curves})
    for number, (name, points) in enumerate(sorted(curves.items())):
        colour = COLOURS[kinds.index(name.split(",")[0]) % len(COLOURS)]
        dash = ' stroke-dasharray="5 4"' if name.endswith("lagrange") else ""
        points = sorted(points)
        path_of = " ".join(f"{'ML'[i > 0]}{at(*p)[0]:.1f} {at(*p)[1]:.1f}" for i, p in enumerate(points))
        out.append(f'<path d="{path_of}" fill="none" stroke="{colour}" stroke-width="2"{dash}/>')
        out += [f'<circle cx="{at(*p)[0]:.1f}" cy="{at(*p)[1]:.1f}" r="3" fill="{colour}"/>' for p in points]
        exponent = fitted_exponent(points, start)
        text = name
        if exponent is not None:
            exponents[name] = exponent
            text += f": exponent {exponent:.2f}"
        y = top + 16 + 20 * number
        out.append(f'<path d="M{width - right + 12} {y - 4}h26" stroke="{colour}" stroke-width="2"{dash}/>'
                   f'<text x="{width - right + 44}" y="{y}">{text}</text>')
    out.append("</svg>")
    return "\n".join(out) + "\n", exponents
