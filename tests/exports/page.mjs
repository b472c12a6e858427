// page.mjs CHROMIUM WITH_FRAMES.html WITHOUT.html RELIEF.html: the pages of export.page as visitors use them, with a mouse on a screen and
// with fingers on a phone: the room is there at once, one walks and stays inside, turns it, moves its lamp, and nothing is fetched.
import assert from "node:assert/strict";
import { Browser, urlOf, webgl } from "../browser/browser.mjs";

const [program, with_frames, without, relief] = process.argv.slice(2);
const position = browser => browser.evaluate("shown.position()");
const distance = (a, b) => Math.hypot(...a.map((value, axis) => value - b[axis]));
const fingers = (browser, type, ...points) => browser.send("Input.dispatchTouchEvent", { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });

/// Two fingers, [from, to] each.
async function slide(browser, ...ways) {
    await fingers(browser, "touchStart", ...ways.map(([from]) => from));
    for (const share of [0.25, 0.5, 0.75, 1])
        await fingers(browser, "touchMove", ...ways.map(([from, to]) => from.map((value, axis) => value + share * (to[axis] - value))));
    await fingers(browser, "touchEnd");
}

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

async function opened(file, width, height, mobile = false) {
    const browser = new Browser(program, webgl);
    await browser.open();
    await browser.resize(width, height, mobile, mobile ? 2 : 1);
    if (mobile)
        await browser.send("Emulation.setTouchEmulationEnabled", { enabled: true, maxTouchPoints: 5 });
    const begin = Date.now();
    await browser.load(urlOf(file));
    await browser.until(`document.getElementById("room").dataset.ready === "yes"`);
    console.log(`${file.split("/").at(-1)} at ${width} x ${height}: shown after ${Date.now() - begin} ms`);
    const start = await browser.seen();
    assert(start.part > 0.5, `at the start the room fills ${start.part} of the canvas`);
    assert.equal(await browser.evaluate(`document.getElementById("room").dataset.mode`), "walk");
    assert.equal(await browser.evaluate(`document.getElementById("walk").getAttribute("aria-pressed")`), "true");
    assert(await browser.evaluate(`Array.from(document.querySelectorAll("button:not([hidden])")).every(button => { const box = button.getBoundingClientRect(); return box.right <= innerWidth && box.height >= 44; })`));
    const end = async () => {
        browser.checkQuiet(urlOf(file));
        await browser.close();
    };
    return { browser, start, end };
}

/// How far a place is outside the box of the room: a camera may have stood outside of what it saw.
const beyond = (browser, at) => browser.evaluate(`Math.hypot(...${JSON.stringify(at)}.map((value, axis) => Math.max(0, room.low[axis] - value, value - room.low[axis] - room.extent[axis])))`);

// Without frames it begins at the widest place; what one does there is the same.
{
    const { browser, end } = await opened(without, 1280, 800);
    await end();
}
// With a relief, a lamp follows the pointer, and nothing else moves.
{
    const { browser, start, end } = await opened(relief, 1280, 800);
    const home = await position(browser);
    await browser.click("#light");
    assert.equal((await browser.seen()).sum, start.sum, "the light moves by itself");
    await browser.mouse("mousePressed", 300, 300);
    const left = await browser.seen();
    assert.notEqual(left.sum, start.sum, "pressing does not bring the lamp");
    await browser.mouse("mouseMoved", 900, 500);
    assert.notEqual((await browser.seen()).sum, left.sum, "dragging does not move the lamp");
    await browser.mouse("mouseReleased", 900, 500);
    assert(distance(await position(browser), home) < 1e-9, "the lamp moves the visitor");
    await browser.click("#light");
    assert.equal(await browser.evaluate(`document.getElementById("room").dataset.mode`), "walk");
    await end();
}
{
    const { browser, start, end } = await opened(with_frames, 1280, 800);
    const home = await position(browser);
    await browser.drag([600, 400], [400, 420]);
    assert.notEqual((await browser.seen()).sum, start.sum, "dragging does not look around");
    assert(distance(await position(browser), home) < 1e-9, "looking around moves");
    const steps = [];
    for (const code of ["KeyW", "KeyA", "KeyS", "KeyD"]) {
        steps.push(await hold(browser, code, 2000));
        assert(await beyond(browser, steps.at(-1)) <= await beyond(browser, home) + 0.1, `${code} leads outside, to ${steps.at(-1)}`);
    }
    assert(distance(steps[0], home) > 0.3 || distance(steps[2], steps[0]) > 0.3, "keys do not walk");
    await browser.wheel(600, 400, 400);
    await browser.click("#orbit");
    const outside = await browser.seen();
    assert(outside.part > 0.05 && outside.part < 0.95, `from outside the room fills ${outside.part} of the canvas`);
    assert.equal(await browser.evaluate(`document.getElementById("orbit").getAttribute("aria-pressed")`), "true");
    const far = await position(browser);
    await browser.drag([600, 400], [800, 400]);
    assert(distance(await position(browser), far) > 0.3, "dragging does not turn the room");
    await browser.wheel(600, 400, -400);
    await browser.click("#walk");
    assert.equal((await browser.seen()).sum, start.sum, "the way back inside leads elsewhere");
    await end();
}

const { browser, start, end } = await opened(with_frames, 390, 844, true);
const home = await position(browser);
await fingers(browser, "touchStart", [200, 400]);
await fingers(browser, "touchMove", [120, 400]);
await fingers(browser, "touchEnd");
assert.notEqual((await browser.seen()).sum, start.sum, "a finger does not look around");
assert(distance(await position(browser), home) < 1e-9, "a finger moves");
let walked = 0;
for (const y of [280, 520]) {
    const before = await position(browser);
    await slide(browser, [[150, 400], [150, y]], [[250, 400], [250, y]]);
    walked = Math.max(walked, distance(await position(browser), before));
}
assert(walked > 0.3, `two fingers walk ${walked} m`);
await browser.click("#orbit");
const far = await position(browser);
await slide(browser, [[150, 400], [90, 400]], [[250, 400], [310, 400]]);
assert(distance(await position(browser), far) > 0.3, "two fingers bring the room no nearer");
assert(await browser.evaluate(`document.documentElement.scrollWidth <= innerWidth`));
await end();

// Without WebGL it says so.
const plain = new Browser(program, ["--disable-3d-apis"]);
await plain.open(urlOf(with_frames));
await plain.until(`document.querySelector(".message")?.textContent.includes("no WebGL")`);
assert.deepEqual(plain.problems, []);
await plain.close();
console.log("the pages of the room: all well");
