"""Opens a page of talus-export in headless Chromium.

PAGE: of test/support/small_terrain.h; moves the pointer, clicks twice, switches layers, and checks what is shown, on a
desktop and on a phone.
URL: of a page of talus-live; checks that the map is drawn.
PAGE PICTURE: takes a picture of part of it with the values under the pointer and a profile.
Exit code 77 where there is no browser."""
import os
import sys
import time

try:
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.by import By
except ImportError:
    print('no selenium: install python3-selenium and chromium-driver')
    sys.exit(77)
if not os.path.exists('/usr/bin/chromedriver'):
    print('no Chromium: install chromium-driver')
    sys.exit(77)


def browser(phone=False):
    options = webdriver.ChromeOptions()
    for a in ('--headless=new', '--no-sandbox', '--disable-gpu', '--disable-dev-shm-usage', '--window-size=1180,720', '--hide-scrollbars'):
        options.add_argument(a)
    if phone:
        options.add_experimental_option(
            'mobileEmulation', {'deviceMetrics': {'width': 390, 'height': 844, 'pixelRatio': 2, 'touch': True}})
    options.set_capability('goog:loggingPrefs', {'browser': 'ALL'})
    return webdriver.Chrome(options=options, service=Service('/usr/bin/chromedriver'))


def wait_for(what, condition):
    for _ in range(200):
        value = condition()
        if value:
            return value
        time.sleep(0.05)
    raise AssertionError('no ' + what)


def show(page):
    page.get(sys.argv[1] if '://' in sys.argv[1] else 'file://' + os.path.abspath(sys.argv[1]))
    wait_for('page that is ready', lambda: page.execute_script('return document.body.dataset.ready'))


def point_at(page, x_m, y_m, click=False):
    place = page.execute_script(  # from the middle of the map, as Selenium counts
        'const p = talus_map.latLngToContainerPoint([arguments[1], arguments[0]]), s = talus_map.getSize();'
        'return [Math.round(p.x - s.x / 2), Math.round(p.y - s.y / 2)]', x_m, y_m)
    move = ActionChains(page).move_to_element_with_offset(page.find_element(By.ID, 'map'), *place)
    (move.click() if click else move).perform()


def take_picture(page, file):
    page.execute_script('talus_map.setView([2, 30], 0.75, {animate: false})')
    for x_m, y_m in ((31, -9), (50, 9)):
        point_at(page, x_m, y_m, click=True)
    wait_for('profile', lambda: page.find_elements(By.CSS_SELECTOR, '#profile svg path'))
    point_at(page, 8, 6)
    time.sleep(1.5)
    page.save_screenshot(file)


def check_channels(page, layers, text):
    """Of the map that talus_export.cpp writes."""
    point_at(page, 1.25, 3.25)  # on the box
    wait_for('label of the box', lambda: 'label, what stands 7' in text('values'))
    assert 'label 4' in text('values') and 'red 200' in text('values'), text('values')
    painted = lambda rgb: page.execute_script(
        'let n = 0; for (const c of document.querySelectorAll(".leaflet-tile-pane canvas"))'
        ' { const p = c.getContext("2d").getImageData(0, 0, 512, 512).data;'
        ' for (let i = 0; i < p.length; i += 4) n += p[i + 3] > 0 && arguments[0].every((v, k) => v === p[i + k]); }'
        ' return n', rgb)
    for layer, rgb, cells in (('Colour', [200, 100, 50], 50 * 40 - 25), ('Colour', [10, 20, 30], 25),
                              ('label', [214, 39, 40], 50 * 40), ('label, what stands', [197, 176, 213], 25)):
        next(l for l in layers if l.text.strip() == layer).click()
        wait_for('cells of ' + layer, lambda: painted(rgb) == cells)
    assert 'class 7' in text('legend'), text('legend')


def check_layout(page, hint):
    """Two places give a profile, all of it is on the screen, and nothing lies over a switch."""
    text = lambda of: page.find_element(By.ID, of).text
    assert hint in text('values'), text('values')
    assert 'm² known' in text('legend'), text('legend')
    for x_m, y_m in ((-0.5, 4.0), (3.5, 4.0)):
        point_at(page, x_m, y_m, click=True)
        wait_for('values', lambda: 'ground' in text('values') or 'distance' in text('profile'))
    wait_for('profile', lambda: page.find_elements(By.CSS_SELECTOR, '#profile svg path'))
    outside = page.execute_script(
        'const inside = (r, w) => r.left >= 0 && r.top >= 0 && r.right <= w.innerWidth && r.bottom <= w.innerHeight;'
        'return [...document.querySelectorAll(".leaflet-control-layers label, #profile, #legend")].filter(e => {'
        ' const r = e.getBoundingClientRect();'
        ' return !inside(r, window) || !e.contains(document.elementFromPoint(r.x + r.width / 2, r.y + r.height / 2));'
        '}).map(e => e.id || e.textContent)')
    assert not outside, outside


def check_live(page):
    text = lambda of: page.find_element(By.ID, of).text
    wait_for('frame', lambda: page.execute_script('return document.body.dataset.live'))
    assert 'live, ' in text('live') or 'no data for ' in text('live'), text('live')
    assert 'scans' in text('legend'), text('legend')
    wait_for('path', lambda: page.find_elements(By.CSS_SELECTOR, '.leaflet-overlay-pane path'))
    middle = page.execute_script('const c = talus_map.getCenter(); return [c.lng, c.lat]')
    for off_m in (0, 1):
        point_at(page, middle[0] - off_m, middle[1], click=True)
    wait_for('profile', lambda: page.find_elements(By.CSS_SELECTOR, '#profile svg path'))
    for layer in page.find_elements(By.CSS_SELECTOR, '.leaflet-control-layers-base label'):
        layer.click()
        wait_for('cells of ' + layer.text, lambda: page.execute_script(
            'const c = document.querySelector(".leaflet-latest-pane canvas");'
            'return c.getContext("2d").getImageData(0, 0, c.width, c.height).data.some(v => v > 0)'))
    errors = [e for e in page.get_log('browser') if e['level'] == 'SEVERE']
    assert not errors, errors


def check(page):
    text = lambda of: page.find_element(By.ID, of).text
    point_at(page, 1.25, 3.25)  # on the box
    wait_for('value of the box', lambda: 'stands on it 0.50 m' in text('values'))
    assert 'ground 1.22 m' in text('values') and 'traversability 0.00' in text('values'), text('values')
    point_at(page, 4.5, 3.25)
    wait_for('unknown cell', lambda: 'not seen' in text('values'))
    point_at(page, -0.5, 4.0, click=True)
    point_at(page, 3.5, 4.0, click=True)
    wait_for('profile', lambda: 'distance' in text('profile'))
    distance_m = float(text('profile').split('distance ')[1].split(' m')[0])
    assert abs(distance_m - 4) < 0.05, distance_m
    assert 'ground rises by 0.4' in text('profile') or 'ground rises by 0.39' in text('profile'), text('profile')
    assert page.find_elements(By.CSS_SELECTOR, '#profile svg path')

    layers = page.find_elements(By.CSS_SELECTOR, '.leaflet-control-layers-base label')
    assert [l.text for l in layers][:3] == ['Traversability', 'Ground', 'Hill-shade'], [l.text for l in layers]
    for layer in layers:
        layer.click()
        wait_for('legend of ' + layer.text, lambda: layer.text.strip() in text('legend'))
        # All cells that are known are painted.
        painted = lambda: page.execute_script(
            'let n = 0; for (const c of document.querySelectorAll(".leaflet-tile-pane canvas"))'
            ' { const p = c.getContext("2d").getImageData(0, 0, 512, 512).data;'
            ' for (let i = 3; i < p.length; i += 4) n += p[i] > 0; } return n')
        wait_for('cells of ' + layer.text, lambda: painted() == 50 * 40)
    if 'Colour' in [l.text.strip() for l in layers]:
        check_channels(page, layers, text)
    page.save_screenshot('page.png')
    assert os.path.getsize('page.png') > 5000
    errors = [e for e in page.get_log('browser') if e['level'] == 'SEVERE']
    assert not errors, errors


def with_browser(phone, *steps):
    page = browser(phone)
    try:
        show(page)
        for step in steps:
            step(page)
    finally:
        page.quit()


if '://' in sys.argv[1]:
    with_browser(True, check_live)
elif len(sys.argv) > 2:
    with_browser(False, lambda page: take_picture(page, sys.argv[2]))
else:
    if 'channels' not in sys.argv[1]:  # whose switches scroll on a phone
        with_browser(True, lambda page: check_layout(page, 'Tap a place'))
    with_browser(False, lambda page: check_layout(page, 'Click two places'), show, check)
