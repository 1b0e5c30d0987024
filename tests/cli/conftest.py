"""Runs that write the same files whether plotly is installed or not."""

import pytest


@pytest.fixture(scope="module", autouse=True)
def _no_page_by_default():
    """As without the extra `report`; test_report.py has it again."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("loopelastica.report.page.write.is_available", lambda: False)
        yield
