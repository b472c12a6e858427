// What every page must keep to.
import assert from "node:assert/strict";

/// The pictures decode, the page holds together on a wide and on a narrow screen, in light and in dark, nothing was fetched, and nothing
/// complained.
export async function checkPage(browser, url) {
    const broken = await browser.evaluate(`Promise.all(Array.from(document.images).map(image => image.decode().then(() => "", () => image.alt || image.src.slice(0, 80)))).then(names => names.filter(Boolean))`);
    assert.deepEqual(broken, []);
    for (const scheme of ["light", "dark"])
        for (const [width, height, mobile] of [[1280, 900, false], [400, 800, true]]) {
            await browser.send("Emulation.setEmulatedMedia", { features: [{ name: "prefers-color-scheme", value: scheme }] });
            await browser.resize(width, height, mobile);
            assert(await browser.evaluate(`document.documentElement.scrollWidth <= window.innerWidth + 1`), `the page is wider than ${width} px`);
        }
    browser.checkQuiet(url);
}
