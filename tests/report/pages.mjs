// What every page must keep to.
import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";

/// The pictures decode, the page holds together on a wide and on a narrow screen, in light and in dark, nothing was fetched, and nothing
/// complained. With a folder for it, pictures of the page.
export async function checkPage(browser, url, name, shots) {
    const broken = await browser.evaluate(`Promise.all(Array.from(document.images).map(image => image.decode().then(() => "", () => image.alt || image.src.slice(0, 80)))).then(names => names.filter(Boolean))`);
    assert.deepEqual(broken, []);
    for (const scheme of ["light", "dark"])
        for (const [width, height, mobile] of [[1280, 900, false], [400, 800, true]]) {
            await browser.send("Emulation.setEmulatedMedia", { features: [{ name: "prefers-color-scheme", value: scheme }] });
            await browser.send("Emulation.setDeviceMetricsOverride", { width, height, deviceScaleFactor: 1, mobile });
            assert(await browser.evaluate(`document.documentElement.scrollWidth <= window.innerWidth + 1`), `the page is wider than ${width} px`);
            if (shots) {
                const whole = await browser.evaluate("document.documentElement.scrollHeight");
                const { data } = await browser.send("Page.captureScreenshot", { captureBeyondViewport: true, clip: { x: 0, y: 0, width, height: whole, scale: 1 } });
                writeFileSync(`${shots}/${name}-${scheme}-${width}.png`, Buffer.from(data, "base64"));
            }
        }
    // The driver remarks that reading the canvas back takes time.
    assert.deepEqual(browser.problems.filter(problem => !problem.includes("GPU stall due to ReadPixels")), []);
    assert.deepEqual(browser.requests.filter(request => request !== url && !request.startsWith("data:") && !request.startsWith("blob:")), []);
}
