"""report_moments_check.py MOMENTS.html: opens the report of report_test.cpp's capsule body with the efforts of
pendulum_efforts.hpp in headless Chromium and prints every fault of its joint moments and ground forces."""

import math
import os
import sys
import time

from page_browser import Browser
from report_page_check import CONTRAST, expect, problems

# The pixels of a canvas that have one colour: [[left, right, top, bottom], mean row, [top, bottom] at some columns]
COLOURED = """((canvas, [r, g, b], solid, columns = []) => {
  const copy = document.createElement('canvas'); copy.width = canvas.width; copy.height = canvas.height;
  const pen = copy.getContext('2d'); pen.drawImage(canvas, 0, 0);
  const data = pen.getImageData(0, 0, copy.width, copy.height).data;
  let box = null, sum = 0, count = 0; const at = columns.map(() => null);
  for (let y = 0; y < copy.height; ++y) for (let x = 0; x < copy.width; ++x) {
    const i = 4 * (y * copy.width + x);
    if (Math.abs(data[i] - r) > 3 || Math.abs(data[i + 1] - g) > 3 || Math.abs(data[i + 2] - b) > 3) continue;
    if (solid ? data[i + 3] < 250 : data[i + 3] < 40) continue;
    box = box ? [Math.min(box[0], x), Math.max(box[1], x), box[2], y] : [x, x, y, y];
    sum += y; ++count;
    const column = columns.indexOf(x);
    if (column >= 0) at[column] = at[column] ? [at[column][0], y] : [y, y];
  }
  return [box, count ? sum / count : null, at];
})"""

LEFT, RIGHT, CENTRE = [0, 114, 178], [213, 94, 0], [179, 38, 30]  # charts.js, the gravity centre's --bad


def press(browser, words):
    """Presses the section's button with this label."""
    browser.run(f"[...document.querySelectorAll('#moments button')].find(b => b.textContent === '{words}').click(), "
                "new Promise(r => setTimeout(r, 200))")


def plots(browser):
    """Each chart's plotting area, on the page and on its canvas."""
    return browser.run("""[...document.querySelectorAll('#moments .chart')].map(chart => {
      const over = chart.querySelector('.u-over').getBoundingClientRect(), canvas = chart.querySelector('canvas').getBoundingClientRect();
      return {left: over.left, top: over.top, width: over.width, height: over.height, x: over.left - canvas.left, y: over.top - canvas.top};
    })""")


def curve(browser, chart, colour, columns, solid=True):
    return browser.run(f"{COLOURED}(document.querySelectorAll('#moments .chart canvas')[{chart}], {colour}, "
                       f"{str(solid).lower()}, {columns})")


def moment(t):
    """The left shank's moment, as in pendulum_efforts.hpp."""
    swing = math.sin(math.pi * t)
    return 4 * 9.81 * 0.2 * math.sin(0.3 + 0.5 * swing) - 0.25 * 0.5 * math.pi**2 * swing


def check_curves(browser):
    """The left knee's curve and band, measured in its own height between t = 0.5 s and 1.5 s."""
    area = plots(browser)[1]
    column = lambda t: round(area["x"] + t / 2 * area["width"])
    times = (0.25, 0.5, 0.8, 1.2, 1.5)
    _, _, lines = curve(browser, 1, LEFT, [column(t) for t in times])
    if None in lines:
        problems.append(f"the moment's curve is not drawn at {times}: {lines}")
        return
    middle = dict(zip(times, [(top + bottom) / 2 for top, bottom in lines]))
    scale = (middle[1.5] - middle[0.5]) / (moment(0.5) - moment(1.5))  # pixels per N m
    for t in times:
        expect(abs(middle[0.5] + scale * (moment(0.5) - moment(t)) - middle[t]) < 3,
               f"at {t} s the moment lies at {middle[t]} of {middle}")
    # +-2 deviations, each a tenth of the moment, away from grid lines
    _, _, [band] = curve(browser, 1, LEFT, [column(0.53)], solid=False)
    half, expected = (band[1] - band[0]) / 2, 0.2 * moment(0.53) * scale
    expect(abs(half - expected) < 3, f"the band's half is {half} pixels, not {expected}")
    for name, chart in (("angle", 0), ("moment", 1)):
        box, _, _ = curve(browser, chart, RIGHT, [])
        expect(box is not None and box[3] - box[2] > 30, f"the right knee's {name} is not drawn: {box}")


def clock(browser):
    return browser.run("Number(document.querySelector('.transport input').value)")


def cursors(browser):
    return browser.run("""[...document.querySelectorAll('#moments .now')].map(line =>
      line.hidden ? -1 : (line.getBoundingClientRect().left + 1 - line.parentElement.getBoundingClientRect().left) / line.parentElement.clientWidth)""")


def reading(browser):
    """The left knee's moment in the chart's legend."""
    return browser.run("document.querySelectorAll('#moments .chart')[1].querySelectorAll('.u-value')[1].textContent")


def check_cursor(browser):
    """Seeking the player moves the charts' line; a press and a drag in a chart move the player."""
    browser.run("window.borelli.seek(0.5)")
    expect(all(abs(at - 0.25) < 0.005 for at in cursors(browser)), f"at 0.5 s the lines stand at {cursors(browser)}")
    expect(reading(browser) == f"{moment(0.5):.2f}", f"at 0.5 s the legend reads {reading(browser)}, not {moment(0.5):.2f}")
    browser.run("document.querySelectorAll('#moments .chart')[1].scrollIntoView({block: 'center'})")
    area = plots(browser)[1]
    mouse = lambda kind, share, **more: browser.call(
        "Input.dispatchMouseEvent", type=kind, x=area["left"] + share * area["width"], y=area["top"] + area["height"] / 2, **more)
    mouse("mouseMoved", 0.3)
    mouse("mousePressed", 0.4, button="left", clickCount=1)
    expect(abs(clock(browser) - 0.8) < 0.01, f"a press at 0.8 s sends the player to {clock(browser)}")
    mouse("mouseMoved", 0.7, button="left", buttons=1)
    expect(abs(clock(browser) - 1.4) < 0.01, f"a drag to 1.4 s sends the player to {clock(browser)}")
    mouse("mouseReleased", 0.7, button="left", clickCount=1)
    mouse("mouseMoved", 0.2)
    expect(abs(clock(browser) - 1.4) < 0.01, "the pointer moves the player without a button")
    expect(all(abs(at - 0.7) < 0.005 for at in cursors(browser)), f"at 1.4 s the lines stand at {cursors(browser)}")
    browser.call("Input.dispatchMouseEvent", type="mouseMoved", x=5, y=5)
    browser.run("window.borelli.seek(0.5)")
    expect(reading(browser) == f"{moment(0.5):.2f}", f"with the pointer gone, the legend reads {reading(browser)}")


def check_words(browser):
    text = lambda selector: browser.run(f"document.querySelector('{selector}').textContent").replace("\u00a0", " ")
    peak = moment(0.5)
    words = text(".peak-words li")
    for part in (f"peak moment {peak:.2f} ± {peak / 10:.2f} N m ({peak / 50:.3f} ± {peak / 500:.3f} N m/kg) at 0.50 s",
                 "60 % of the variance comes from joint centres, 30 % from masses, 10 % from markers"):
        expect(part in words, f"the words '{part}' are not in '{words}'")
    joints = browser.run("[...document.querySelectorAll('#moments .choices button')].map(b => b.textContent)")
    expect(joints == ["Knee", "Hip"], f"the joints to choose are {joints}")
    expect(browser.run("document.querySelectorAll('#moments .peaks tbody tr').length") == 5, "the static table is gone")
    expect(browser.run("document.querySelector('#body').nextElementSibling.id") == "moments", "the section is not after the player")
    top = lambda: browser.run("document.querySelector('.moment-charts').textContent")
    expect("moment (N m/kg)" not in top(), "moments are by mass unasked")
    browser.run("document.querySelector('.moment-looks input').click(), new Promise(r => setTimeout(r, 200))")
    expect(reading(browser) == f"{peak / 50:.4f}", f"by mass the moment reads {reading(browser)}, not {peak / 50:.4f}")
    browser.run("document.querySelector('.moment-looks input').click()")
    press(browser, "Hip")
    press(browser, "internal rotation")
    expect("Left hip, internal rotation: peak moment −9.00 N m" in text(".peak-words"), f"the hip says {text('.peak-words')}")
    expect(browser.run("document.querySelectorAll('#moments .chart').length") == 3, "the hip has not three charts")
    press(browser, "Knee")


def arrow(browser, t):
    """Height of the arrow and of the gravity centre's ball above the arrow's foot, pixels; None: no arrow."""
    browser.run("[...document.querySelectorAll('.looks button')].find(b => b.textContent === 'Front').click(), new Promise(r => setTimeout(r, 100))")
    seen = lambda colour: browser.run(f"window.borelli.seek({t}), {COLOURED}(document.querySelector('.stage canvas'), {colour}, true)")
    box, _, _ = seen(LEFT)
    ball = seen(CENTRE)[1]
    return (box[3] - box[2] + 1, box[3] - ball) if box else None


def check_arrows(browser):
    """500 N are half a metre; the gravity centre is 0.95 m above the force's point."""
    for t in (1.0, 1.5):
        seen = arrow(browser, t)
        if seen is None:
            problems.append(f"no arrow at {t} s")
            continue
        # a pixel at each end, and up to 3 % for the camera's height
        expect(abs(seen[0] / seen[1] - 0.5 * t / 0.95) < 0.03, f"at {t} s the arrow has {seen[0]} of {seen[1]} pixels")
    expect(arrow(browser, 0.1) is None, "a force without a point is drawn")
    toggle = "[...document.querySelectorAll('.looks label')].find(l => l.textContent.startsWith('Ground forces')).click()"
    browser.run(toggle)
    expect(arrow(browser, 1.0) is None, "the arrows cannot be hidden")
    browser.run(toggle)
    expect(arrow(browser, 1.0) is not None, "the arrows do not come back")


def check_layouts(browser, page):
    for width, dark in ((1280, True), (390, False)):
        browser.open(page, width, dark=dark)
        browser.run("window.borelli.ready")
        wide = browser.run("document.documentElement.scrollWidth")
        expect(wide <= width, f"at {width} pixels the page is {wide} wide")
        for selector in ("#moments .quiet", ".choices button", ".moment-looks button", ".peak-words li", ".peaks tbody th", ".residuals td"):
            contrast = browser.run(f"{CONTRAST}('{selector}')")
            # WCAG 2.1, 1.4.3 (AA): 4.5 for text
            expect(contrast >= 4.5, f"{selector} has a contrast of {contrast:.2f} at {width} pixels")
    browser.open(page, printed=True)
    browser.run("window.borelli.ready")
    breaks = browser.run("[...document.querySelectorAll('#moments h2, #moments h3')].map(e => getComputedStyle(e).breakAfter)")
    expect(len(breaks) == 4 and set(breaks) == {"avoid"}, f"in print the headings' breaks are {breaks}")
    # without JavaScript the page has the tables
    browser.call("Emulation.setScriptExecutionDisabled", value=True)
    browser.call("Page.navigate", url="file://" + os.path.abspath(page))
    for _ in range(200):  # no listener for the page's end runs now
        if browser.run("document.readyState") == "complete":
            break
        time.sleep(0.1)
    shown = browser.run("[...document.querySelectorAll('main #moments td')].filter(cell => cell.offsetHeight > 0).length")
    expect(shown == 5 * 6 + 3 * 4, f"without JavaScript {shown} cells are shown")
    browser.call("Emulation.setScriptExecutionDisabled", value=False)


def main(page):
    browser = Browser("chromium")
    try:
        browser.open(page)
        browser.run("window.borelli.ready")
        browser.run("new Promise(r => setTimeout(r, 300))")
        check_curves(browser)
        check_cursor(browser)
        check_words(browser)
        check_arrows(browser)
        check_layouts(browser, page)
        said = [line for line in browser.said if "GPU stall due to ReadPixels" not in line]  # this test reads them
        expect(not said, f"the console says: {said}")
    finally:
        browser.close()
    for problem in problems:
        print(problem, file=sys.stderr)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
