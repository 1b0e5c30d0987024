"""The page in a headless Chromium, as a reader meets it: no network, no errors, all switches."""

import shutil
import time

import pytest

from loopelastica.report.page.write import write_report

pytest.importorskip("plotly")
webdriver = pytest.importorskip("selenium.webdriver", reason="selenium drives the browser")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
DRIVER = shutil.which("chromedriver")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed"),
    pytest.mark.skipif(DRIVER is None, reason="chromedriver is not installed"),
]
# WebGL by software
ARGUMENTS = (
    *("--headless=new", "--no-sandbox", "--disable-gpu", "--use-gl=angle"),
    *("--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
)
DRAWN = """window.Plotly && document.getElementById("waiting").textContent === ""
    && document.querySelector("#scene canvas") !== null"""


class Page:
    """A page that is open."""

    def __init__(self, driver):
        self.driver = driver

    def open(self, path):
        self.driver.get_log("browser")
        self.driver.get(path.resolve().as_uri())
        self.wait(DRAWN)

    def run(self, script):
        return self.driver.execute_script(script)

    def wait(self, condition, seconds=90):
        end = time.monotonic() + seconds
        while not self.run(f"return {condition}"):
            assert time.monotonic() < end, self.text("waiting")
            time.sleep(0.1)

    def click(self, selector):
        self.run(f"document.querySelector({selector!r}).click()")

    def text(self, name):
        return self.run(f"return document.getElementById({name!r}).textContent")

    def drawn(self):
        """Names of what is drawn."""
        return self.run("return document.getElementById('scene').data.map((one) => one.name)")

    def column(self, name):
        """Texts of a column of the table."""
        script = f"""
            const head = [...document.querySelectorAll("#table th button")];
            const k = head.findIndex((button) => button.dataset.key === {name!r});
            const rows = [...document.querySelectorAll("#table tbody tr")];
            return rows.map((row) => row.children[k].textContent)"""
        return self.run(script)

    def errors(self):
        return [e["message"] for e in self.driver.get_log("browser") if e["level"] == "SEVERE"]


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    profile = tmp_path_factory.mktemp("profile")
    for argument in (*ARGUMENTS, "--window-size=1400,1200", f"--user-data-dir={profile}"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options, webdriver.ChromeService(DRIVER))
    # whatever asks the network is an error on the console
    driver.execute_cdp_cmd("Network.enable", {})
    driver.execute_cdp_cmd("Network.setBlockedURLs", {"urls": ["http://*", "https://*"]})
    yield Page(driver)
    driver.quit()


@pytest.fixture(scope="module")
def few(tmp_path_factory, make_run, atoms):
    out = make_run(tmp_path_factory.mktemp("few"), ["A6-9", "C6-9", "B6-9"], atoms=atoms)
    return write_report(out)


def test_the_first_loop_is_drawn_without_an_error(page, few, tmp_path):
    page.open(few)
    assert page.text("title") == "A6-9.pdb · A6-9"
    assert {"stem", "own loop", "candidate 1", "labels"} <= set(page.drawn())
    assert "candidate 2" not in page.drawn()
    assert page.errors() == []
    # and is there to be seen: in the picture is the colour of the first candidate
    from matplotlib.colors import to_rgb
    from matplotlib.image import imread

    picture = tmp_path / "page.png"
    page.driver.find_element("id", "scene").screenshot(str(picture))
    colour = to_rgb(page.run("return window.report.colours.ranks[0]"))
    shown = imread(picture)[:, :, :3]
    hue = shown / shown.max(axis=2, keepdims=True).clip(0.05)
    wanted = [part / max(colour) for part in colour]
    assert (abs(hue - wanted).max(axis=2) < 0.12).sum() > 500


def test_switches_show_and_hide_candidates_atoms_and_the_loop_of_the_file(page, few):
    page.open(few)
    page.click("#candidate-2")
    assert "candidate 2" in page.drawn()
    page.click("#candidate-1")
    assert "candidate 1" not in page.drawn()
    page.click("#atoms-2")
    assert "atoms 2" in page.drawn()
    page.click("#show-own")
    assert "own loop" not in page.drawn()
    page.click("#show-error")
    assert "expected error" in page.drawn()
    page.click("#all")
    assert {"candidate 1", "candidate 2"} <= set(page.drawn())
    curves = page.run("return document.getElementById('curvature').data.map((one) => one.name)")
    assert "candidate 1" in curves
    assert page.errors() == []


def test_a_candidate_says_its_residues_and_the_error_to_expect(page, few):
    page.open(few)
    texts = page.run("""
        const one = document.getElementById("scene").data.find((t) => t.name === "candidate 1");
        return [...new Set(one.hovertext)]""")
    assert len(texts) == 4
    assert texts[0].startswith("A.U6<br>candidate 1: straight rod<br>expected error ")


def test_a_click_in_the_table_shows_another_loop_and_the_buttons_go_on(page, few):
    page.open(few)
    page.click("tr[data-index='2']")
    page.wait(DRAWN)
    assert page.text("title") == "B6-9.pdb · B6-9"
    page.click("#previous")
    page.wait(DRAWN)
    assert page.text("title") == "C6-9.pdb · C6-9"
    assert page.errors() == []


def test_the_table_is_sorted_by_its_headings_and_filtered_by_words(page, few):
    page.open(few)
    assert page.column("loop") == ["A6-9", "C6-9", "B6-9"]
    page.click("button[data-key=loop]")
    assert page.column("loop") == ["A6-9", "B6-9", "C6-9"]
    page.click("button[data-key=loop]")
    assert page.column("loop") == ["C6-9", "B6-9", "A6-9"]
    page.run("""
        const filter = document.getElementById("filter");
        filter.value = "b6 UUCG";
        filter.dispatchEvent(new Event("input"))""")
    assert page.column("loop") == ["B6-9"]


def test_loops_of_a_long_run_are_loaded_when_they_are_chosen(page, tmp_path, make_run):
    out = make_run(tmp_path / "long", [f"A{k}" for k in range(60)])
    page.open(write_report(out))
    assert len(page.column("loop")) == 50
    assert page.text("count") == "60 loops"
    page.click("#pages button:last-child")
    assert len(page.column("loop")) == 10
    page.click("tr[data-index='57']")
    page.wait(DRAWN)
    assert page.text("title") == "A57.pdb · A57"
    assert "candidate 1" in page.drawn()
    assert page.errors() == []
    # a page that was moved away from its folders says so
    (out / "2koc_A58" / "scene.js").unlink()
    page.click("tr[data-index='58']")
    page.wait("document.getElementById('waiting').textContent.startsWith('2koc_A58/scene.js')")


def test_hostile_names_are_text(page, tmp_path, make_run):
    name = "<img src=x onerror=window.hurt=1>"
    out = make_run(tmp_path / "out", [name])
    (out / "failures.csv").write_text(f"file,failure\n{name},{name}: empty\n")
    page.open(write_report(out))
    assert page.text("title").endswith(name)
    assert name in page.text("failures")
    assert page.run("return window.hurt === undefined && !document.querySelector('img')")
    assert page.errors() == []


def test_a_phone_scrolls_in_one_direction(page, few):
    size = {"width": 390, "height": 844, "deviceScaleFactor": 1, "mobile": True}
    page.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    try:
        page.open(few)
        assert page.run("return document.documentElement.scrollWidth") == 390
        assert page.run("return document.getElementById('scene').clientWidth") < 390
    finally:
        page.driver.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
