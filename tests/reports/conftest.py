"""Reports of archives made by hand, and a browser that is really there."""

import shutil

import pytest


@pytest.fixture
def tree():
    """An archive in memory with a diagram and a chart."""
    from support.archives import both

    return both()


@pytest.fixture
def write(tmp_path):
    """Function that writes the report of a tree and returns it."""

    from chaosdrill.archive import save
    from chaosdrill.reports import report

    def written(tree, name="result"):
        return report(save(tree, tmp_path / f"{name}.nc"))

    return written


@pytest.fixture(scope="session")
def written(tmp_path_factory):
    """The report of that archive, for tests that only read it."""
    from support.archives import both

    from chaosdrill.archive import save
    from chaosdrill.reports import report

    return report(save(both(), tmp_path_factory.mktemp("report") / "result.nc"))


@pytest.fixture(scope="session")
def chromium():
    """A real Chromium without a window; tests that need it are skipped where there is none."""
    webdriver = pytest.importorskip("selenium.webdriver", reason="selenium is not installed")
    browser = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    driver = shutil.which("chromedriver")
    if browser is None or driver is None:
        pytest.skip("no Chromium with its chromedriver; Debian has them in chromium and chromium-driver")
    options = webdriver.ChromeOptions()
    options.binary_location = browser
    for argument in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--window-size=1100,900"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    started = webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))
    yield started
    started.quit()


@pytest.fixture
def visit(chromium):
    """Function that opens a page; what earlier ones left in the logs is gone."""

    def opened(path):
        for kind in ("browser", "performance"):
            chromium.get_log(kind)
        chromium.get(path.resolve().as_uri())
        return chromium

    return opened
