"""report_page_check.py FULL.html LITTLE.html: opens both reports in headless Chromium from file://, poses the body,
uses all controls, and prints every fault. FULL is the report of report_test.cpp's capsule body."""

import os
import sys
import time

from page_browser import Browser

problems = []


def expect(truth, what):
    if not truth:
        problems.append(what)


# A picture's fingerprint and whether it shows anything: the sum of its pixels' hashes, its distinct colours.
PICTURE = """(canvas => {
  const copy = document.createElement('canvas'); copy.width = canvas.width; copy.height = canvas.height;
  const pen = copy.getContext('2d'); pen.drawImage(canvas, 0, 0);
  const data = new Uint32Array(pen.getImageData(0, 0, copy.width, copy.height).data.buffer);
  let hash = 0; for (const pixel of data) hash = (Math.imul(hash, 31) + pixel) | 0;
  return {hash, colours: new Set(data).size, pixels: data.length};
})"""

# WCAG 2.1 contrast of an element's text against the first opaque background behind it
CONTRAST = """(selector => {
  const probe = document.createElement('canvas').getContext('2d', {willReadFrequently: true});
  const rgba = colour => { probe.clearRect(0, 0, 1, 1); probe.fillStyle = colour; probe.fillRect(0, 0, 1, 1);
    return probe.getImageData(0, 0, 1, 1).data; };
  const light = c => [0, 1, 2].map(i => c[i] / 255).map(v => v <= .04045 ? v / 12.92 : ((v + .055) / 1.055) ** 2.4)
    .reduce((sum, v, i) => sum + v * [.2126, .7152, .0722][i], 0);
  const element = document.querySelector(selector);
  if (!element) return -1;
  let back = element; while (back.parentElement && rgba(getComputedStyle(back).backgroundColor)[3] < 255) back = back.parentElement;
  const [a, b] = [light(rgba(getComputedStyle(element).color)), light(rgba(getComputedStyle(back).backgroundColor))];
  return (Math.max(a, b) + .05) / (Math.min(a, b) + .05);
})"""


# How many pixels have the ellipsoid's yellow hue
YELLOW = """(canvas => {
  const copy = document.createElement('canvas'); copy.width = canvas.width; copy.height = canvas.height;
  const pen = copy.getContext('2d'); pen.drawImage(canvas, 0, 0);
  const data = pen.getImageData(0, 0, copy.width, copy.height).data; let count = 0;
  for (let i = 0; i < data.length; i += 4) count += data[i + 3] > 60 && data[i] > 150 && data[i + 1] > 140 && data[i + 2] < 0.62 * data[i];
  return count;
})"""


def picture(browser, selector):
    return browser.run(f"{PICTURE}(document.querySelector('{selector}'))")


# The body's height and middle in the player, as shares of the stage, from the rows that hold colours
# (the ground and its shadow are grey).
STANDS = """(() => {
  const canvas = document.querySelector('.stage canvas'), copy = document.createElement('canvas');
  copy.width = canvas.width; copy.height = canvas.height;
  const pen = copy.getContext('2d'); pen.drawImage(canvas, 0, 0);
  const data = pen.getImageData(0, 0, copy.width, copy.height).data, rows = [];
  for (let y = 0; y < copy.height; ++y) {
    let coloured = 0;
    for (let at = 4 * y * copy.width; at < 4 * (y + 1) * copy.width; at += 4) {
      const [r, g, b] = data.subarray(at, at + 3);
      coloured += data[at + 3] === 255 && Math.max(r, g, b) - Math.min(r, g, b) > 60;
    }
    if (coloured > 3) rows.push(y / copy.height);
  }
  return [rows.at(-1) - rows[0], (rows.at(-1) + rows[0]) / 2];
})()"""


def check_opening(browser):
    """At first the body is large, centred, and not behind the play button."""
    tall, middle = browser.run(STANDS)
    expect(tall > 0.6, f"the player opens with a body {tall:.2f} of its height")
    expect(abs(middle - 0.5) < 0.1, f"the player opens with the body's middle at {middle:.2f} of its height")
    button, stage = (browser.run(f"(box => [box.left, box.right])(document.querySelector('{selector}').getBoundingClientRect())")
                     for selector in (".big-play", ".stage"))
    expect(button[0] > stage[0] + 0.75 * (stage[1] - stage[0]), "the play button lies over the body")


def check_body(browser):
    expect(abs(browser.run("window.borelli.duration") - 2) < 1e-6, "the player does not know the motion's two seconds")
    # seek() draws before it returns, so picture and pose come from one task
    at = {t: browser.run(f"window.borelli.seek({t}), {PICTURE}(document.querySelector('.stage canvas'))")
          for t in (0, 0.25, 1.1, 2)}
    for t, seen in at.items():
        expect(seen["colours"] > 200, f"the body's picture at {t} s has only {seen['colours']} colours")
    expect(len({seen["hash"] for seen in at.values()}) == 4, "the body does not move with seek()")
    again = browser.run(f"window.borelli.seek(0.25), {PICTURE}(document.querySelector('.stage canvas'))")
    expect(again["hash"] == at[0.25]["hash"], "the same time gives another picture")
    expect(browser.run("document.querySelector('.time').textContent") == "0.25 / 2.00 s", "the clock is wrong")
    expect(browser.run("document.querySelectorAll('.legend .part').length") == 16, "the legend has not 16 parts")
    lit = browser.run("document.querySelector('.legend .part').click(), new Promise(r => setTimeout(r, 200)).then(() => "
                      f"{PICTURE}(document.querySelector('.stage canvas')))")
    expect(lit["hash"] != again["hash"], "choosing a part changes nothing")
    browser.run("document.querySelector('.legend .part').click()")
    browser.run("window.borelli.seek(0), document.querySelector('.round').click()")
    # the clock advances within 20 s, even if this machine draws slowly
    moved = browser.run("""new Promise(resolve => { const began = performance.now(), look = () => {
      const time = Number(document.querySelector('.transport input').value);
      if (time > 0.05 || performance.now() - began > 20000) resolve(time); else setTimeout(look, 50); }; look(); })""")
    expect(0.05 < moved < 2, f"after play the clock stands at {moved} s")
    browser.run("document.querySelector('.round').click()")


def scrolled_by_wheel(browser, modifiers=0):
    """The page's scroll, and whether the scene changes, when the wheel turns over the stage."""
    browser.run("document.activeElement.blur(), document.querySelector('.stage').scrollIntoView({block: 'center'})")
    x, y, before = browser.run("(b => [b.left + b.width / 3, b.top + b.height / 2, scrollY])(document.querySelector('.stage').getBoundingClientRect())")
    seen = picture(browser, ".stage canvas")
    browser.call("Input.dispatchMouseEvent", type="mouseWheel", x=x, y=y, deltaX=0, deltaY=120, modifiers=modifiers)
    browser.run("new Promise(r => setTimeout(r, 400))")
    return browser.run("scrollY") - before, picture(browser, ".stage canvas")["hash"] != seen["hash"]


def check_pick(browser):
    """A part selected in the list or in the table is highlighted and shows its inertia; the stage stays in view."""
    moved, changed = scrolled_by_wheel(browser)
    expect(moved > 50 and not changed, f"the wheel over the stage scrolls the page by {moved}")
    moved, changed = scrolled_by_wheel(browser, modifiers=2)
    expect(moved == 0 and changed, f"the wheel with Ctrl scrolls the page by {moved}, and the scene {'changes' if changed else 'does not change'}")
    browser.run("window.borelli.seek(0.25), scrollTo(0, document.body.scrollHeight), document.querySelector('tbody .pick').click()")
    browser.run("new Promise(r => setTimeout(r, 1200))")
    name, pressed = browser.run("[document.querySelector('tbody .pick').textContent, document.querySelector('.part[aria-pressed=true] .name')?.textContent]")
    expect(name == pressed, f"{name} is picked in the table, and {pressed} is lit")
    top, bottom = browser.run("(b => [b.top, b.bottom])(document.querySelector('.stage').getBoundingClientRect())")
    expect(top >= -1 and bottom <= 901, f"the stage lies from {top} to {bottom} after a pick in the table")
    note = browser.run("document.querySelector('.ellipsoid-note').innerText")
    moments = browser.run("JSON.parse(document.getElementById('report').textContent).table.parts[0].derived.principal_moments_kgm2.map(m => m * 1e4)")
    said = [float(word) for word in note.replace(",", " ").split() if word.replace(".", "").isdigit()]
    expect(len(said) == 3 and all(abs(a - b) < 6e-3 * b for a, b in zip(said, moments)), f"the note '{note}' does not tell {moments}")
    layer = lambda name: browser.run(f"[...document.querySelectorAll('.looks label')].find(l => l.textContent === '{name}')"
                                     ".querySelector('input').click(), new Promise(r => setTimeout(r, 300))")
    seen = lambda: picture(browser, ".stage canvas")["hash"]
    # the head is yellow too, so the parts are hidden to find the ellipsoid
    before = seen()
    layer("Parts")
    expect(seen() != before, "the layer Parts changes nothing")
    yellow = lambda: browser.run(f"{YELLOW}(document.querySelector('.stage canvas'))")
    with_it = yellow()
    expect(with_it > 50, f"the picked part's ellipsoid has {with_it} pixels")
    browser.run("document.querySelector('.part[aria-pressed=true]').click(), document.activeElement.blur(), new Promise(r => setTimeout(r, 300))")
    expect(yellow() < 0.2 * with_it, f"{yellow()} of the ellipsoid's {with_it} pixels stay after its part is left")
    layer("Parts")
    before = seen()
    layer("Frames")
    expect(seen() != before, "the layer Frames changes nothing")
    layer("Frames")


def check_tap(browser, page):
    """On a phone the stage stays in view while the list of parts below it is tapped."""
    browser.open(page, 390)
    browser.run("window.borelli.ready")
    browser.run("(list => { list.at(-1).scrollIntoView({block: 'end'}); list.at(-1).click(); })([...document.querySelectorAll('.legend .part')])")
    browser.run("new Promise(r => setTimeout(r, 300))")
    top, bottom, part = browser.run("[...(b => [b.top, b.bottom])(document.querySelector('.stage').getBoundingClientRect()), "
                                    "[...document.querySelectorAll('.legend .part')].at(-1).getBoundingClientRect().top]")
    expect(top > -1 and bottom - top > 200 and part >= bottom - 1, f"after a tap at {part} the stage lies from {top} to {bottom}")


def check_without_script(browser, page):
    """The inertia table's numbers are in the page."""
    browser.call("Emulation.setScriptExecutionDisabled", value=True)
    browser.call("Page.navigate", url="file://" + os.path.abspath(page))
    for _ in range(200):  # no listener for the page's end runs now
        if browser.run("document.readyState") == "complete":
            break
        time.sleep(0.1)
    rows, mass, wide = browser.run("[document.querySelectorAll('main section tbody tr').length, [...document.querySelectorAll('main section tbody tr')].at(-1)"
                                   ".cells[2].textContent, document.documentElement.scrollWidth]")
    expected = browser.run("JSON.parse(document.getElementById('report').textContent).table.body.mass_kg")
    expect(rows == 17 and abs(float(mass) - expected) < 6e-4, f"without JavaScript {rows} rows and the mass {mass} are shown")
    browser.call("Emulation.setScriptExecutionDisabled", value=False)


def check_scan(browser):
    for plane in ("coronal", "sagittal", "axial"):
        before = picture(browser, f".view.{plane} canvas")
        expect(before["colours"] > 10, f"the {plane} slice is blank")
        browser.run(f"(s => {{ s.value = Number(s.value) + 6; s.dispatchEvent(new Event('input')); }})"
                    f"(document.querySelector('.view.{plane} input'))")
        expect(picture(browser, f".view.{plane} canvas")["hash"] != before["hash"], f"the {plane} slider moves nothing")
    before = picture(browser, ".view.axial canvas")
    browser.run("(s => { s.value = 0; s.dispatchEvent(new Event('input')); })"
                "([...document.querySelectorAll('.slice-controls label')].find(l => l.textContent == 'Parts').querySelector('input'))")
    expect(picture(browser, ".view.axial canvas")["hash"] != before["hash"], "the parts' opacity changes nothing")
    expect(browser.run("document.querySelectorAll('.coronal-sum circle').length") == 15, "not 15 joint centres drawn")
    # the report's left hip, a sphere: two pictures of four radii, with its circle in the middle
    expect(browser.run("document.querySelectorAll('.fit').length") == 2, "not two close-ups of the one sphere")
    for n in (1, 2):
        expect(picture(browser, f".fit:nth-child({n}) canvas")["colours"] > 3, f"close-up {n} of the sphere is blank")
    r, at, side = browser.run("(c => [c.r.baseVal.value, c.cx.baseVal.value, c.ownerSVGElement.width.baseVal.value])"
                              "(document.querySelector('.fit circle.core'))")
    expect(abs(r / side - 0.25) < 1e-9 and abs(at / side - 0.5) < 1e-9, "the sphere's circle is not where the fit is")
    # position of the left knee (97, 0, 440) mm in the picture: the copy extends from -292 to 292 mm
    # and from the grid's end at -26 mm to 1756 mm, a voxel of 12 mm more or less
    x, y = browser.run("""(() => { const text = [...document.querySelectorAll('.coronal-sum text')].find(t => t.textContent == 'Left knee');
      const ring = text.previousElementSibling, box = document.querySelector('.coronal-sum canvas').getBoundingClientRect(),
      at = ring.getBoundingClientRect(); return [(at.x + at.width / 2 - box.x) / box.width, (at.y + at.height / 2 - box.y) / box.height]; })()""")
    expect(abs(x - (97 + 292) / 584) < 0.025 and abs(y - (1756 - 440) / 1782) < 0.01, f"the left knee's ring lies at {x:.3f}, {y:.3f}")
    # the plane of the left elbow bisects the angle between (190, 0, 1400) - (212, 0, 1090) - (228, -25, 810) mm and
    # crosses an arm of 36 to 45 mm radius; the voxels are of 12 mm
    lines = browser.run("""[...document.querySelectorAll('.coronal-sum .cut-plane')].map(line => {
      const path = line.querySelector('.core').getAttribute('d').match(/[-0-9.]+/g).map(Number),
      box = document.querySelector('.coronal-sum canvas').getBoundingClientRect(),
      at = document.querySelector('.coronal-sum svg').getBoundingClientRect();
      return [line.querySelector('title').textContent, path.map((v, i) => i % 2 ? 1756 - (v + at.y - box.y) / box.height * 1782
        : (v + at.x - box.x) / box.width * 584 - 292)]; })""")
    elbow = dict(lines).get("Left elbow: cut plane")
    if elbow:
        middle = (elbow[0] + elbow[2]) / 2, (elbow[1] + elbow[3]) / 2
        expect(abs(middle[0] - 212) < 14 and abs(middle[1] - 1090) < 14, f"the elbow's cut lies about {middle}")
        expect(40 < elbow[2] - elbow[0] < 115, f"the elbow's cut reaches from {elbow[0]} to {elbow[2]} mm")
        # normal: the mean of the unit vectors (22, -310) and (16, -280): the line rises by 0.0641 to the left
        expect(abs((elbow[3] - elbow[1]) / (elbow[2] - elbow[0]) - 0.0641) < 0.01, f"the elbow's cut runs {elbow}")
    else:
        problems.append(f"no cut plane of the left elbow among {lines}")
    # no line if the plane does not cut the labels (the knees' capsules meet above it)
    expect("Left knee: cut plane" not in dict(lines), "a plane that cuts nothing is drawn")
    expect("de Leva (1996)" in browser.run("document.querySelector('.joints-view figcaption').textContent"), "the convention is not named")


def check_histogram(browser, width):
    """Bands and lines are at the thresholds, and texts do not overlap."""
    texts = browser.run("""[...document.querySelectorAll('.histogram text')].map(text => {
      const box = text.getBoundingClientRect(); return [text.textContent, box.left, box.top, box.right, box.bottom]; })""")
    words = [text for text, *_ in texts]
    # the scan holds -1000 to 700 HU; the thresholds are those of segmentation/body/tissues.hpp
    for word in ("air below −950", "lung to −300", "fat to −25", "soft tissue to 160", "bone above 160",
                 "CT number (HU)", "voxels per 10 HU"):
        expect(word in words, f"at {width} pixels the histogram does not say '{word}' but {words}")
    for i, (word, *a) in enumerate(texts):
        for other, *b in texts[:i]:
            expect(a[0] >= b[2] or b[0] >= a[2] or a[1] >= b[3] - 2 or b[1] >= a[3] - 2,
                   f"at {width} pixels the histogram's '{word}' lies on '{other}'")
        expect(a[0] >= 0 and a[2] <= width, f"at {width} pixels the histogram's '{word}' leaves the page")
    # the line at 160 HU, and the body's values (40 and 700 HU) to its sides, by the labels of the axis
    ticks = {int(word.replace("−", "-")): (a[0] + a[2]) / 2 for word, *a in texts
             if word.replace("−", "").isdigit() and abs(a[1] - next(t[2] for t in texts if t[0] == "0")) < 3}
    ticks_top = next(a[1] for word, *a in texts if word == "0")
    low, high = min(ticks), max(ticks)
    pixels = lambda hu: ticks[low] + (hu - low) / (high - low) * (ticks[high] - ticks[low])
    lines = browser.run("[...document.querySelectorAll('.histogram path.threshold')].map(l => l.getBoundingClientRect()).map(b => [b.left, b.top])")
    for (line, end), hu in zip(lines, (-950, -300, -25, 160), strict=True):
        for word, *a in texts:
            expect(line < a[0] or line > a[2] or end > a[3] - 3 or a[1] > ticks_top - 3,
                   f"at {width} pixels the line at {hu} HU crosses '{word}'")
        expect(abs(line - pixels(hu)) < 1.5, f"at {width} pixels the threshold of {hu} HU lies at {line}, not {pixels(hu)}")


def check_masses(browser, width):
    """Each bar shows its standard deviation, 0.5 % of the body's mass (report_test.cpp), on both sides of its end."""
    bars = browser.run("""[...document.querySelectorAll('figure.mass-chart svg[role=img] > g')].map(row => {
      const bar = row.querySelector('rect').getBoundingClientRect(), error = row.querySelector('.error-bar .core').getBoundingClientRect();
      return [row.querySelector('title').textContent, bar.left, bar.right, error.left, error.right]; })""")
    ticks = browser.run("""[...document.querySelectorAll('.masses text.tick')].filter(t => /^[0-9.]+$/.test(t.textContent))
      .map(t => [Number(t.textContent), t.getBoundingClientRect()]).map(([v, b]) => [v, (b.left + b.right) / 2])""")
    percent = (ticks[-1][1] - ticks[0][1]) / (ticks[-1][0] - ticks[0][0])
    expect(len(bars) == 16, f"at {width} pixels there are {len(bars)} bars")
    for title, left, right, low, high in bars:
        share = float(title.split(": ")[1].split(" ")[0])
        expect(abs(right - left - share * percent) < 1, f"at {width} pixels the bar of '{title}' is {right - left} long")
        expect(abs(high - (right + 0.5 * percent)) < 2 and abs(low - max(left, right - 0.5 * percent)) < 2,
               f"at {width} pixels the error bar of '{title}' runs from {low} to {high}, its bar ends at {right}")
        expect("± 0.25 kg" in title, f"'{title}' does not say its deviation")


def check_words(browser):
    expect(browser.run("document.querySelector('h1').children.length") == 0, "the subject's name became markup")
    expect("</script><b id=x>" in browser.run("document.querySelector('h1').textContent"), "the subject's name is not whole")
    for id in ("body", "inertia", "scan", "motion", "run"):
        expect(browser.run(f"document.querySelector('section#{id} h2') !== null"), f"the section '{id}' is missing")
    expect(browser.run("document.querySelectorAll('#panel-mass tbody tr').length") == 16, "the table has not 16 rows")
    expect(browser.run("document.querySelectorAll('.masses[role=img] > g').length") == 16, "the chart has not 16 bars")
    expect(browser.run("document.querySelectorAll('#motion .uplot').length") == 3, "not three charts (energy, drift, multipliers)")
    # a capsule's gravity centre is at 50 % of its length; de Leva (1996), table 4, male shank KJC-AJC: 43.95 %;
    # Dumas et al. (2007), table 2, male shank: 41.0 %
    differs = browser.run("[...document.querySelectorAll('#panel-gravity-centre .difference')].map(cell => cell.textContent)")
    expect(differs == ["+13.8 %", "+22.0 %"] * 2, f"the shanks' gravity centres differ by {differs}")
    # one foot is cut, so shares of the body's mass are not compared
    expect(browser.run("document.querySelector('#panel-mass .difference') === null"), "a cut body's shares are compared")
    expect("and no shank</i>" in browser.run("document.querySelector('#panel-how-measured').textContent"), "the remarks are not shown")
    expect("can be trusted" in browser.run("document.querySelector('.certificate').textContent"), "no verdict")
    expect("cut off" in browser.run("document.querySelector('.warnings').textContent"), "the warning is not shown")
    expect(browser.run("document.querySelector('.files a').getAttribute('href')") == "inertia/table.csv", "no link to the table")


def check_access(browser):
    """Every control has an accessible name."""
    controls = {"button", "slider", "combobox", "checkbox", "tab", "link"}
    for node in browser.call("Accessibility.getFullAXTree")["nodes"]:
        role = node.get("role", {}).get("value")
        if role in controls and not node.get("ignored") and not node.get("name", {}).get("value", "").strip():
            problems.append(f"a {role} has no name")


def check_layout(browser, page, width, **media):
    browser.open(page, width, **media)
    browser.run("window.borelli.ready")
    wide = browser.run("document.documentElement.scrollWidth")
    expect(wide <= width, f"at {width} pixels the page is {wide} wide")
    check_histogram(browser, width)
    check_masses(browser, width)
    over = browser.run("(box => box.scrollWidth - box.clientWidth)(document.querySelector('.joints-view .scroll'))")
    expect(over <= 0 or width < 420, f"at {width} pixels the joints' table is {over} too wide")
    for selector in ("h1", ".source", ".facts dt", ".warnings li", ".help", ".numbers tbody th", ".difference",
                     "[role=tab]", ".histogram-figure .key", ".certificate li", ".quiet", ".files a"):
        contrast = browser.run(f"{CONTRAST}('{selector}')")
        # WCAG 2.1, 1.4.3 (AA): 4.5 for text
        expect(contrast >= 4.5, f"{selector} has a contrast of {contrast:.2f} at {width} pixels, {media or 'light'}")


def main(full, little):
    browser = Browser("chromium")
    try:
        browser.open(full)
        browser.run("window.borelli.ready")
        check_words(browser)
        check_opening(browser)
        check_body(browser)
        check_pick(browser)
        check_scan(browser)
        check_access(browser)
        check_layout(browser, full, 1280, dark=True)
        check_layout(browser, full, 390)
        check_tap(browser, full)
        check_without_script(browser, full)
        browser.open(full, printed=True)
        browser.run("window.borelli.ready")
        shown = browser.run("[...document.querySelectorAll('[role=tabpanel]')].filter(p => p.offsetHeight > 0).length")
        expect(shown == 5, f"print shows {shown} of the table's five views")
        browser.open(little)
        browser.run("window.borelli.ready")
        expect(browser.run("document.querySelector('h1').textContent") == "little", "a report of little has no title")
        expect(browser.run("document.querySelector('#body') === null"), "a report without a body has a player")
        said = [line for line in browser.said if "GPU stall due to ReadPixels" not in line]  # this test reads them
        expect(not said, f"the console says: {said}")
        pages = {"file://" + os.path.abspath(path) for path in (full, little)}
        foreign = [address for address in browser.requested if address not in pages and not address.startswith("data:")]
        expect(not foreign, f"the page asked for {foreign}")
    finally:
        browser.close()
    for problem in problems:
        print(problem, file=sys.stderr)
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
