"""The report in a real browser: `report.py REPORT CHROMIUM FOLDER [PICTURE]`.

Checks that the page fetches nothing, draws every plot, fits wide and narrow screens, names strikes, opens them by mouse and keyboard, filters,
goes dark and prints; leaves pictures in FOLDER for whoever looks at them, and the first screen in PICTURE. Exits with 1 and says what does not hold.
"""

import sys
from pathlib import Path

import pypdf
from checking import check, finish
from playwright.sync_api import sync_playwright

report, chromium, folder = Path(sys.argv[1]).resolve(), sys.argv[2], Path(sys.argv[3])
picture = sys.argv[4] if len(sys.argv) > 4 else None
folder.mkdir(parents=True, exist_ok=True)


def contrast(page, selector):
    """Contrast of text and ground by WCAG 2.2, from the colours that the browser computes."""
    return page.evaluate(
        """(selector) => {
            const light = (rgb) => { const [r, g, b] = rgb.map((v) => { v /= 255; return v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4; }); return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
            const numbers = (text) => text.match(/[\\d.]+/g).map(Number);
            const element = document.querySelector(selector);
            const ink = light(numbers(getComputedStyle(element).color).slice(0, 3));
            let ground = element;
            while (ground && (numbers(getComputedStyle(ground).backgroundColor)[3] ?? 1) === 0) ground = ground.parentElement;
            const paper = light(numbers(getComputedStyle(ground ?? document.body).backgroundColor).slice(0, 3));
            return (Math.max(ink, paper) + 0.05) / (Math.min(ink, paper) + 0.05);
        }""",
        selector,
    )


with sync_playwright() as playwright:
    browser = playwright.chromium.launch(
        executable_path=chromium,
        args=["--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-component-update", "--disable-sync", "--no-first-run"],
    )

    def open_page(width, height, scheme="light"):
        page = browser.new_page(viewport={"width": width, "height": height}, color_scheme=scheme)
        page.set_default_timeout(60_000)
        page.on("request", lambda request: check(request.url.startswith(("file:", "data:")), f"asks for nothing but itself: {request.url[:80]}") if not request.url.startswith(("file:", "data:")) else None)
        page.on("pageerror", lambda error: check(False, f"no script fails: {error}"))
        page.on("console", lambda said: check(False, f"the console is silent: {said.text}") if said.type == "error" else None)
        page.goto(report.as_uri())
        page.wait_for_function("document.documentElement.dataset.drawn !== undefined")
        return page

    size = report.stat().st_size
    strikes = None
    for width, height, scheme in [(1400, 900, "light"), (1400, 900, "dark"), (400, 800, "light"), (400, 800, "dark")]:
        page = open_page(width, height, scheme)
        name = f"{width}_{scheme}"
        page.screenshot(path=folder / f"{name}.png")
        plots, drawn = page.locator("figure.plot").count(), int(page.evaluate("document.documentElement.dataset.drawn"))
        check(plots > 5 and plots == drawn, f"{name}: all of {plots} plots are drawn ({drawn})")
        over = page.evaluate("document.documentElement.scrollWidth - innerWidth")
        check(over <= 0, f"{name}: nothing is wider than the screen ({over} px)")
        wide = page.evaluate("[...document.querySelectorAll('table')].filter((table) => table.checkVisibility() && table.scrollWidth > table.clientWidth + 1).map((table) => table.textContent.slice(0, 40))")
        check(not wide, f"{name}: no table is wider than its place {wide}")
        answers = page.locator(".answer")
        check(answers.count() == 4, f"{name}: four answers")
        bottom = answers.last.bounding_box()
        check(bottom["y"] + bottom["height"] <= height, f"{name}: all answers are on the first screen")
        for selector in [".answer .said", ".lead", ".note", "button.open"]:
            seen = contrast(page, selector)
            check(seen >= 4.5, f"{name}: text can be read, {selector} ({seen:.1f} : 1)")
        if name == "400_light":
            page.screenshot(path=folder / "400_whole.png", full_page=True)
        page.close()

    page = open_page(1400, 900)
    if picture:
        page.screenshot(path=picture)
    strikes = page.evaluate("Object.keys(JSON.parse(document.getElementById('strikes').textContent).strikes).length")
    check(size < 3e6, f"{size / 1e6:.2f} MB with {strikes} strikes listed")

    # By mouse: a dot names its strike, a click opens it.
    over = page.locator("figure.plot .u-over").filter(visible=True).first
    plot = page.locator("figure.plot:has(.holder[role=application])").first
    over = plot.locator(".u-over")
    over.scroll_into_view_if_needed()
    place = page.evaluate(
        """() => { const figure = document.querySelector('figure.plot:has(.holder[role=application])');
            const holder = figure.querySelector('.holder'); holder.focus();
            holder.dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowRight', bubbles: true }));
            const marker = figure.querySelector('.marker'); const at = [parseFloat(marker.style.left), parseFloat(marker.style.top)];
            holder.blur(); return at; }"""
    )
    over.hover(position={"x": place[0], "y": place[1]})
    tip = page.locator(".tip").text_content()
    check(page.locator(".tip").is_visible() and "m/s" in tip, f"a dot names its strike: {tip}")
    page.screenshot(path=folder / "1400_hover.png")
    over.click(position={"x": place[0], "y": place[1]})
    dialog = page.locator("dialog.strike")
    check(dialog.is_visible() and dialog.locator("h2").text_content() in tip, "a click opens it")
    check(dialog.locator("canvas").count() == 2, "it has its track and its residual")
    page.screenshot(path=folder / "1400_strike.png")
    page.keyboard.press("Escape")
    check(not dialog.is_visible(), "Escape closes it")

    # By keyboard alone.
    plot.locator(".holder").focus()
    for _ in range(3):
        page.keyboard.press("ArrowRight")
    named = page.locator(".tip").text_content()
    page.keyboard.press("Enter")
    check(dialog.is_visible() and dialog.locator("h2").text_content() in named, f"arrows and Enter open one: {named}")
    page.keyboard.press("Escape")

    # Filters.
    count = lambda: int(page.locator("output[name=count]").text_content().split()[0])
    before = count()
    page.select_option("select[name=split]", "test")
    held_out = count()
    check(0 < held_out < before, f"filters: {held_out} of {before} are held out")
    page.fill("input[name=high]", "0.7")
    check(count() < held_out, f"filters: {count()} of them up to 0.7 m/s")
    page.select_option("select[name=session]", index=1)
    page.screenshot(path=folder / "1400_filtered.png")
    named = page.locator("div.list tbody tr").count()
    check(named <= 12, "the list has pages")
    page.close()

    # On paper.
    page = open_page(1000, 900, "dark")
    page.pdf(path=folder / "report.pdf", format="A4")
    headings = page.locator("h2, h3").all_text_contents()
    page.close()
    browser.close()

pages = [page.extract_text().strip().splitlines() for page in pypdf.PdfReader(folder / "report.pdf").pages]
orphans = [lines[-1] for lines in pages if lines and lines[-1].strip() in headings]
check(not orphans, f"paper: no heading ends one of {len(pages)} pages {orphans}")
finish()
