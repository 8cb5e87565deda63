"""Take the picture of the report page: the blade sample, in a browser without a screen.

Run from the repository's root: python docs/pictures/report.py (needs the extras report and test, chromium and
chromedriver).
"""

from _browser import report_page, take

with report_page("gcode_samples/blade_5axis.nc", (1400, 1180)) as browser:
    # in the middle of the blade, where C is at its velocity
    take(browser, "report.png", "(report.setCursor(report.data.frames >> 1), report.view('fit'))")
