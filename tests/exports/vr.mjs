// vr.mjs CHROMIUM PAGE.html IWER.js: the page of export.page in an emulated headset: it is entered where a camera stood, at the height of the
// head; teleports and turns go where they should, and never off the floor.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { Browser, urlOf, webgl } from "../browser/browser.mjs";

const [program, page, iwer] = process.argv.slice(2);
const browser = new Browser(program, webgl);
await browser.open();
await browser.send("Page.addScriptToEvaluateOnNewDocument", {
    source: `${readFileSync(iwer, "utf8")}
        const device = new IWER.XRDevice(IWER.metaQuest3);
        device.installRuntime({ forceInstall: true });
        device.stereoEnabled = true;
        device.position.set(0.1, 1.7, -0.2);
        // A pinch or a stick, held until the frame after it was seen.
        const frames = count => new Promise(done => { const wait = left => left ? setTimeout(() => requestAnimationFrame(() => wait(left - 1)), 5) : done(); wait(count); });`,
});
await browser.resize(320, 160);
await browser.load(urlOf(page));
await browser.until(`document.getElementById("room").dataset.ready === "yes" && !document.getElementById("vr").hidden`);
const start = await browser.evaluate("shown.position()");
await browser.click("#vr");
await browser.until("shown.vr !== undefined");
await browser.evaluate("frames(4)");

const head = () => browser.evaluate("shown.vr.head()");
const calls = await browser.evaluate("shown.renderer.info.render.calls");
assert(calls >= 1 && calls <= 20, `${calls} draw calls per view`);
const camera = await browser.evaluate(`shown.ground.axes.map(axis => axis.dot(new THREE.Vector3(...${JSON.stringify(start)})))`);
const begin = await head();
assert(Math.hypot(begin[0] - camera[0], begin[1] - camera[1]) < 1e-6, `the visitor begins at ${begin}, the camera at ${camera}`);

// Both eyes see the room, from two places.
const { halves } = await browser.seen("canvas");
assert(halves.every(part => part > 0.5), `the eyes see the room in ${halves} of their pictures`);

// Teleports, aimed in many directions by the stick of one hand and the trigger of the other.
let moves = 0, refused = 0, far = 0;
for (let i = 0; i < 12; ++i) {
    const [hand, press, release] = i % 2 ? ["right", `updateAxes("thumbstick", 0, -1)`, `updateAxes("thumbstick", 0, 0)`] : ["left", `updateButtonValue("trigger", 1)`, `updateButtonValue("trigger", 0)`];
    const yaw = i * 2.399963, pitch = -1.3 + 0.08 * i;
    const before = await head();
    await browser.evaluate(`(async () => {
        const hand = device.controllers.${hand};
        hand.position.set(device.position.x, 1.2, device.position.z);
        const turn = new THREE.Quaternion().setFromEuler(new THREE.Euler(${pitch}, ${yaw}, 0, "YXZ"));
        hand.quaternion.set(turn.x, turn.y, turn.z, turn.w);
        await frames(2);
        hand.${press};
        await frames(4);
    })()`);
    await browser.evaluate(`(async () => { device.controllers.${hand}.${release}; await frames(4); })()`);
    const now = await head();
    if (Math.hypot(now[0] - before[0], now[1] - before[1]) < 1e-9) {
        ++refused;
        continue;
    }
    ++moves;
    far = Math.max(far, Math.hypot(now[0] - before[0], now[1] - before[1]));
    assert(await browser.evaluate(`shown.vr.allows(...shown.vr.head())`), `a teleport leads to ${now}, where nobody can stand`);
}
assert(moves >= 3 && far > 0.5, `${moves} teleports, ${far} m at most`);
assert(refused >= 1, "every place is allowed");

// Turns are of 30 degrees, and the head stays where it is.
const standing = await head();
const views = [];
for (let i = 0; i < 4; ++i) {
    await browser.evaluate(`(async () => {
        device.controllers.right.updateAxes("thumbstick", 1, 0);
        await frames(3);
        device.controllers.right.updateAxes("thumbstick", 0, 0);
        await frames(3);
    })()`);
    const turned = await head();
    assert(Math.hypot(turned[0] - standing[0], turned[1] - standing[1]) < 1e-6, "turning moves");
    views.push(await browser.evaluate("shown.vr.yaw()"));
}
for (let i = 1; i < 4; ++i)
    assert(Math.abs(views[i] - views[i - 1] + Math.PI / 6) < 1e-9, `turns lead to ${views}`);

// The session ends, and the page goes on as before.
await browser.evaluate("device.activeSession.end()");
await browser.until("shown.vr === undefined");
await browser.click("#walk");
assert.deepEqual((await browser.evaluate("shown.position()")).map(value => value.toFixed(6)), start.map(value => value.toFixed(6)));
browser.checkQuiet(urlOf(page));
await browser.close();
console.log(`the page in a headset: ${calls} draw calls a view, ${moves} teleports, ${refused} refused: all well`);
