"""chart_page_check.py FOLDER: opens the pages that chart_page_test.cpp wrote there in headless Chromium, on a desktop and
on a phone, and prints every fault."""

import os
import sys
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from page_browser import Browser  # noqa: E402
from report_page_check import CONTRAST, expect, picture, problems  # noqa: E402

PAGES = ("chart", "economy", "volume", "stability", "long")


def place(browser, plot, x, y):
    """The pixel of the window at which a shown plot has this value."""
    browser.run(f"document.querySelectorAll('.plot')[{plot}].scrollIntoView({{block: 'center'}})")
    # a plot's position updates at the scroll event, which comes with the next frame
    browser.run("new Promise(r => requestAnimationFrame(() => requestAnimationFrame(r)))")
    return browser.run(f"""(([left, top], box) => [box.left + left, box.top + top])(window.borelli.plots[{plot}].position({x}, {y}),
      document.querySelectorAll('.plot')[{plot}].querySelector('.u-over').getBoundingClientRect())""")


def read(browser, plot, x, y):
    """The plot's readout with the mouse at a value; None if it shows none."""
    left, top = place(browser, plot, x, y)
    browser.call("Input.dispatchMouseEvent", type="mouseMoved", x=left + 2, y=top)
    return browser.run(f"(tip => tip.hidden ? null : tip.innerText)(document.querySelectorAll('.plot')[{plot}].querySelector('.tip'))")


def choose(browser, words):
    browser.run(f"[...document.querySelectorAll('.choices button')].find(b => b.textContent === '{words}').click()")


def cells(browser, heading):
    """The table below a heading, as rows of cell texts."""
    return browser.run(f"""[...[...document.querySelectorAll('h2, summary')].find(e => e.textContent.startsWith('{heading}')).parentElement
      .querySelectorAll('tbody tr')].map(row => [...row.cells].map(cell => cell.textContent))""")


def check_economy(browser):
    """The readout of the smaller model equals the table's row."""
    change, error, _, coordinates, _, milliseconds, evaluations, _ = cells(browser, "Models")[1]
    expect((error, coordinates, milliseconds, evaluations) == ("0.00032", "2", "7.89", "800"), f"the table says {cells(browser, 'Models')[1]}")
    told = read(browser, 0, 2, 3.2e-4) or ""
    for words in (change, f"error {error}", f"{milliseconds} ms", f"{evaluations} evaluations"):
        expect(words in told, f"the error's chart tells '{told}', without '{words}'")
    choose(browser, "processor time")
    told = read(browser, 1, 2, 7.89) or ""
    expect(f"{milliseconds} ms" in told, f"the time's chart tells '{told}'")
    expect(read(browser, 1, 2.5, 2) is None, "the chart tells a point where there is none")


def check_chart(browser):
    # the second program's third run: 10 columns of work, error of 1e-4 / 10
    [row] = [r for r in cells(browser, "All ") if r[0] == "other rk4" and r[1] == "step 0.01 s"]
    _, _, milliseconds, evaluations, trusted, position, *_ = row
    expect((milliseconds, evaluations, trusted, position) == ("40", "400", "yes", "1e-05"), f"the table says {row}")
    told = read(browser, 0, 40, 1e-5) or ""
    for words in ("other rk4, step 0.01 s", f"{milliseconds} ms, {evaluations} evaluations", f"position {position}"):
        expect(words in told, f"the chart tells '{told}', without '{words}'")
    # six of ten curves are shown at first, one of them the other program's, in its own colour
    shown = browser.run("[...document.querySelectorAll('.plot')[0].querySelectorAll('button[aria-pressed=true]')].map(b => "
                        "[b.textContent, b.querySelector('path').getAttribute('stroke')])")
    front, curves = shown[0], shown[1:]
    expect("front" in front[0] and len(curves) == 6, f"at first {shown} are shown")
    colours = {name == "other rk4": colour for name, colour in curves}
    expect(len(colours) == 2 and len({colour for _, colour in curves}) == 2, f"the programs' colours are {curves}")
    before = picture(browser, ".plot:not([hidden]) canvas")
    browser.run("document.querySelector('.plot details.more button').click()")
    after = picture(browser, ".plot:not([hidden]) canvas")
    expect(before["hash"] != after["hash"], "a curve that is asked for does not appear")
    browser.run("[...document.querySelectorAll('.plot')[0].querySelectorAll('button.key-item')].find(b => b.textContent === 'other rk4').click()")
    expect(read(browser, 0, 40, 1e-5) != told, "a curve that is hidden is told all the same")


def check_volume(browser):
    [row] = [r for r in cells(browser, "Tried") if r[1] == "8 mm"]
    expect(row[2:4] == ["3.75", "8 %"], f"the table says {row}")
    told = read(browser, 0, 8, 8) or ""
    for words in ("8 mm", f"16 parts: error {row[3]}", f"{row[2]} s"):
        expect(words in told, f"the chart tells '{told}', without '{words}'")


def check_stability(browser):
    """Many maps form a list to choose from; a tile has a readout; the first map has hatched tiles and their legend."""
    names = browser.run("[...document.querySelectorAll('.choices option')].map(o => o.value)")
    expect("methods" in names and "rk4" in names and len(names) > 8, f"the maps are {names}")
    told = read(browser, 0, 1, 0.1) or ""
    expect(told.startswith("rk4") and "step 0.1 s: " in told, f"the tile of rk4 tells '{told}'")
    outcome = told.split("step 0.1 s: ")[-1].split("\n")[0]
    legend = browser.run("[...document.querySelectorAll('.plot .key-item')].map(e => e.textContent)")
    expect(outcome in legend, f"the outcome '{outcome}' is not in the legend {legend}")
    browser.run("(s => { s.value = 'verlet'; s.dispatchEvent(new Event('change')); })(document.querySelector('.choices select'))")
    shown = browser.run("[...document.querySelectorAll('.plot')].filter(p => p.offsetHeight > 0).map(p => p.dataset.map)")
    expect(shown == ["verlet"], f"after choosing verlet, {shown} is shown")


def check_long(browser):
    plot = browser.run("[...document.querySelectorAll('.plot')].findIndex(p => p.offsetHeight > 0)")
    name, x, y = browser.run(f"(c => [c.name, c.x[50], c.y[50]])(window.borelli.plots[{plot}].data.curves[0])")
    told = read(browser, plot, x, y) or ""
    expect(told.startswith(name) and f"time: {x:g} s" in told, f"the chart tells '{told}' of {name} at {x} s")


CHECKS = {"chart": check_chart, "economy": check_economy, "volume": check_volume, "stability": check_stability, "long": check_long}


def check_layout(browser, name, path, width, dark):
    browser.open(path, width, dark=dark)
    browser.run("new Promise(r => setTimeout(r, 200))")
    here = f"{name} at {width} pixels{', dark' if dark else ''}"
    wide = browser.run("document.documentElement.scrollWidth")
    expect(wide <= width, f"{here} is {wide} wide")
    drawn = picture(browser, ".plot:not([hidden]) canvas")
    expect(drawn["colours"] > 20, f"{here}: the chart has only {drawn['colours']} colours")
    shown = browser.run("[...document.querySelectorAll('.static')].filter(s => s.offsetHeight > 0).length")
    expect(shown == 0, f"{here}: {shown} static drawings stand beside the charts")
    back = browser.run("getComputedStyle(document.body).backgroundColor").strip("rgb()").split(", ")
    light = sum(map(int, back)) / 3
    expect(light < 60 if dark else light > 200, f"{here}: the background is {back}")
    for selector in ("h1", "header p:last-of-type", ".plot figcaption", ".axis-name", ".small-print", ".numbers thead th",
                     ".numbers tbody th", ".numbers td", "button.key-item[aria-pressed=true]", ".choices button", ".more summary"):
        contrast = browser.run(f"{CONTRAST}('{selector}')")
        # WCAG 2.1, 1.4.3 (AA): 4.5 for text; below 0: the page has no such element
        expect(contrast >= 4.5 or contrast < 0, f"{here}: {selector} has a contrast of {contrast:.2f}")


def check_print(browser, name, path):
    browser.open(path, printed=True)
    browser.run("new Promise(r => setTimeout(r, 200))")
    plots, drawn, live = browser.run("[document.querySelectorAll('.plot').length, [...document.querySelectorAll('.static svg')]"
                                     ".filter(s => s.getBoundingClientRect().height > 100).length, "
                                     "[...document.querySelectorAll('.live')].filter(s => s.offsetHeight > 0).length]")
    expect(plots == drawn and live == 0, f"{name} prints {drawn} drawings of {plots}, and {live} canvases")
    breaks = browser.run("[...document.querySelectorAll('h1, h2')].map(e => getComputedStyle(e).breakAfter)")
    expect(set(breaks) == {"avoid"}, f"{name}: in print the headings' breaks are {breaks}")


def check_without_script(browser, name, path):
    """Without JavaScript the page has drawings and numbers, and hides buttons."""
    browser.call("Emulation.setScriptExecutionDisabled", value=True)
    browser.call("Emulation.setEmulatedMedia", media="", features=[])
    browser.call("Page.navigate", url="file://" + os.path.abspath(path))
    for _ in range(200):  # no listener for the page's end runs now
        if browser.run("document.readyState") == "complete":
            break
        time.sleep(0.1)
    plots, drawn, numbers, buttons = browser.run(
        "[document.querySelectorAll('.plot').length, [...document.querySelectorAll('.static svg')].filter(s => s.getBoundingClientRect().height > 100).length, "
        "[...document.querySelectorAll('section td')].filter(c => c.offsetHeight > 0 && /[0-9]/.test(c.textContent)).length, "
        "[...document.querySelectorAll('.choices')].filter(c => c.offsetHeight > 0).length]")
    expect(plots == drawn > 0, f"without JavaScript {name} shows {drawn} drawings of {plots}")
    expect(numbers >= 6, f"without JavaScript {name} shows {numbers} numbers")
    expect(buttons == 0, f"without JavaScript {name} shows {buttons} rows of buttons")
    browser.call("Emulation.setScriptExecutionDisabled", value=False)


def main(folder):
    browser = Browser("chromium")
    paths = {name: os.path.join(folder, name + ".html") for name in PAGES}
    try:
        for name, path in paths.items():
            expect(os.path.getsize(path) < 400_000, f"{name} has {os.path.getsize(path)} bytes")
            for width, dark in ((1280, False), (1280, True), (390, False)):
                check_layout(browser, name, path, width, dark)
            browser.open(path)
            CHECKS[name](browser)
            check_print(browser, name, path)
            check_without_script(browser, name, path)
        expect(not browser.said, f"the console says: {browser.said}")
        pages = {"file://" + os.path.abspath(path) for path in paths.values()}
        foreign = [address for address in browser.requested if address not in pages and not address.startswith("data:")]
        expect(not foreign, f"the pages asked for {foreign}")
    finally:
        browser.close()
    for problem in problems:
        print(problem, file=sys.stderr)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
