// page.mjs CHROMIUM WITH_FRAMES.html WITHOUT.html RELIEF.html [SHOTS]: the pages of export.page as visitors use them, with a mouse on a screen and with fingers on a
// phone: the room is there at once, one walks and stays inside, turns it, moves its lamp, and nothing is fetched. With a folder for it, pictures.
import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Browser } from "../browser/browser.mjs";

const [program, with_frames, without, relief, shots] = process.argv.slice(2);
const graphics = ["--enable-unsafe-swiftshader", "--use-angle=swiftshader"];

/// How much of the canvas is not the background, and a sum that changes with any point.
const seen = browser => browser.evaluate(`(() => {
    const copy = document.createElement("canvas");
    [copy.width, copy.height] = [64, 64];
    const context = copy.getContext("2d");
    context.drawImage(document.querySelector("#room canvas"), 0, 0, 64, 64);
    const { data } = context.getImageData(0, 0, 64, 64);
    let part = 0, sum = 0;
    for (let i = 0; i < data.length; i += 4) {
        part += Math.abs(data[i] - 0x20) + Math.abs(data[i + 1] - 0x24) + Math.abs(data[i + 2] - 0x2a) > 12;
        sum = (sum * 31 + data[i] + 256 * data[i + 1] + 65536 * data[i + 2]) % 1000000007;
    }
    return { part: part / 4096, sum };
})()`);
const position = browser => browser.evaluate("shown.position()");
const distance = (a, b) => Math.hypot(...a.map((value, axis) => value - b[axis]));
const click = (browser, selector) => browser.evaluate(`document.querySelector("${selector}").click()`);
const shot = async (browser, name) => {
    if (!shots)
        return;
    const { data } = await browser.send("Page.captureScreenshot");
    writeFileSync(`${shots}/${name}.png`, Buffer.from(data, "base64"));
};
const mouse = (browser, type, x, y, more = {}) => browser.send("Input.dispatchMouseEvent", { type, x, y, button: "left", buttons: type === "mouseReleased" ? 0 : 1, clickCount: 1, ...more });
const fingers = (browser, type, ...points) => browser.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });

/// Holds a key until the visitor no longer moves, at most `most_ms`.
async function hold(browser, code, most_ms) {
    await browser.send("Input.dispatchKeyEvent", { type: "keyDown", key: code, code });
    let before = await position(browser);
    for (const end = Date.now() + most_ms; Date.now() < end;) {
        await browser.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => requestAnimationFrame(done))))");
        const now = await position(browser);
        if (distance(before, now) < 1e-6)
            break;
        before = now;
    }
    await browser.send("Input.dispatchKeyEvent", { type: "keyUp", key: code, code });
    return before;
}

async function opened(file, { width, height, mobile = false }) {
    const url = pathToFileURL(resolve(file)).href;
    const browser = new Browser(program, graphics);
    await browser.open("about:blank", "/tmp");
    await browser.send("Emulation.setDeviceMetricsOverride", { width, height, deviceScaleFactor: mobile ? 2 : 1, mobile });
    if (mobile)
        await browser.send("Emulation.setTouchEmulationEnabled", { enabled: true, maxTouchPoints: 5 });
    const begin = Date.now();
    await browser.go(() => browser.send("Page.navigate", { url }));
    await browser.until(`document.getElementById("room").dataset.ready === "yes"`);
    console.log(`${file.split("/").at(-1)} at ${width} x ${height}: shown after ${Date.now() - begin} ms`);
    const start = await seen(browser);
    assert(start.part > 0.5, `at the start the room fills ${start.part} of the canvas`);
    assert.equal(await browser.evaluate(`document.getElementById("room").dataset.mode`), "walk");
    assert.equal(await browser.evaluate(`document.getElementById("walk").getAttribute("aria-pressed")`), "true");
    assert(await browser.evaluate(`Array.from(document.querySelectorAll("button:not([hidden])")).every(button => { const box = button.getBoundingClientRect(); return box.right <= innerWidth && box.height >= 44; })`));
    const end = async () => {
        assert.deepEqual(browser.problems.filter(problem => !problem.includes("GPU stall due to ReadPixels")), []);
        assert.deepEqual(browser.requests.filter(request => request !== url && !request.startsWith("data:") && !request.startsWith("blob:")), []);
        await browser.close();
    };
    return { browser, start, end };
}

/// How far a place is outside the box of the room: a camera may have stood outside of what it saw.
const beyond = (browser, at) => browser.evaluate(`Math.hypot(...${JSON.stringify(at)}.map((value, axis) => Math.max(0, room.low[axis] - value, value - room.low[axis] - room.extent[axis])))`);

// Without frames it begins at the widest place; what one does there is the same.
{
    const { browser, end } = await opened(without, { width: 1280, height: 800 });
    await shot(browser, "bare-desktop-walk");
    await end();
}
// With a relief, a lamp follows the pointer, and nothing else moves.
{
    const { browser, start, end } = await opened(relief, { width: 1280, height: 800 });
    await shot(browser, "relief-walk");
    const home = await position(browser);
    await click(browser, "#light");
    assert.equal((await seen(browser)).sum, start.sum, "the light moves by itself");
    await mouse(browser, "mousePressed", 300, 300);
    const left = await seen(browser);
    await shot(browser, "relief-lamp");
    assert.notEqual(left.sum, start.sum, "pressing does not bring the lamp");
    await mouse(browser, "mouseMoved", 900, 500);
    assert.notEqual((await seen(browser)).sum, left.sum, "dragging does not move the lamp");
    await mouse(browser, "mouseReleased", 900, 500);
    assert(distance(await position(browser), home) < 1e-9, "the lamp moves the visitor");
    await click(browser, "#light");
    assert.equal(await browser.evaluate(`document.getElementById("room").dataset.mode`), "walk");
    await end();
}
{
    const { browser, start, end } = await opened(with_frames, shots ? { width: 1920, height: 1080 } : { width: 1280, height: 800 });
    await shot(browser, "frames-desktop-walk");
    const home = await position(browser);
    await mouse(browser, "mousePressed", 600, 400);
    await mouse(browser, "mouseMoved", 400, 420);
    await mouse(browser, "mouseReleased", 400, 420);
    assert.notEqual((await seen(browser)).sum, start.sum, "dragging does not look around");
    assert(distance(await position(browser), home) < 1e-9, "looking around moves");
    const steps = [];
    for (const code of ["KeyW", "KeyA", "KeyS", "KeyD"]) {
        steps.push(await hold(browser, code, 2000));
        assert(await beyond(browser, steps.at(-1)) <= await beyond(browser, home) + 0.1, `${code} leads outside, to ${steps.at(-1)}`);
    }
    assert(distance(steps[0], home) > 0.3 || distance(steps[2], steps[0]) > 0.3, "keys do not walk");
    await mouse(browser, "mouseWheel", 600, 400, { button: "none", buttons: 0, deltaX: 0, deltaY: 400 });
    await click(browser, "#orbit");
    const outside = await seen(browser);
    assert(outside.part > 0.05 && outside.part < 0.95, `from outside the room fills ${outside.part} of the canvas`);
    assert.equal(await browser.evaluate(`document.getElementById("orbit").getAttribute("aria-pressed")`), "true");
    await shot(browser, "frames-desktop-orbit");
    const far = await position(browser);
    await mouse(browser, "mousePressed", 600, 400);
    await mouse(browser, "mouseMoved", 800, 400);
    await mouse(browser, "mouseReleased", 800, 400);
    assert(distance(await position(browser), far) > 0.3, "dragging does not turn the room");
    await mouse(browser, "mouseWheel", 600, 400, { button: "none", buttons: 0, deltaX: 0, deltaY: -400 });
    await click(browser, "#walk");
    assert.equal((await seen(browser)).sum, start.sum, "the way back inside leads elsewhere");
    await end();
}

const { browser, start, end } = await opened(with_frames, { width: 390, height: 844, mobile: true });
await shot(browser, "phone-walk");
const home = await position(browser);
await fingers(browser, "touchStart", [200, 400]);
await fingers(browser, "touchMove", [120, 400]);
await fingers(browser, "touchEnd");
assert.notEqual((await seen(browser)).sum, start.sum, "a finger does not look around");
assert(distance(await position(browser), home) < 1e-9, "a finger moves");
let walked = 0;
for (const dy of [-120, 120]) {
    const before = await position(browser);
    await fingers(browser, "touchStart", [150, 400], [250, 400]);
    for (const share of [0.25, 0.5, 0.75, 1])
        await fingers(browser, "touchMove", [150, 400 + share * dy], [250, 400 + share * dy]);
    await fingers(browser, "touchEnd");
    walked = Math.max(walked, distance(await position(browser), before));
}
assert(walked > 0.3, `two fingers walk ${walked} m`);
await click(browser, "#orbit");
await shot(browser, "phone-orbit");
const far = await position(browser);
await fingers(browser, "touchStart", [150, 400], [250, 400]);
for (const share of [0.25, 0.5, 0.75, 1])
    await fingers(browser, "touchMove", [150 - 60 * share, 400], [250 + 60 * share, 400]);
await fingers(browser, "touchEnd");
assert(distance(await position(browser), far) > 0.3, "two fingers bring the room no nearer");
assert(await browser.evaluate(`document.documentElement.scrollWidth <= innerWidth`));
await end();

// Without WebGL it says so.
const plain = new Browser(program, ["--disable-3d-apis"]);
await plain.open(pathToFileURL(resolve(with_frames)).href, "/tmp");
await plain.until(`document.querySelector(".message")?.textContent.includes("no WebGL")`);
assert.deepEqual(plain.problems, []);
await plain.close();
console.log("the pages of the room: all well");
