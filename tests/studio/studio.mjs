// studio.mjs CHROMIUM FRESCO FOLDER MODEL PICTURE [SCREENSHOTS]: fresco studio as its user has it, from an empty folder on.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { copyFileSync, existsSync, mkdirSync, readFileSync, rmSync, symlinkSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { seenIn } from "../browser/browser.mjs";
import { drop, has, ready, setting, studioIn, until } from "./page.mjs";

const [program, fresco, folder, model, picture, screenshots] = process.argv.slice(2);
const { saved, served, opened, shoot } = studioIn(folder, program, fresco, screenshots);

let server = await served();
assert.match(server.address, /^http:\/\/127\.0\.0\.1:\d+\/[0-9a-f]{32}\/$/);
const strange = server.address.replace(/[0-9a-f]{32}/, "0".repeat(32));
assert.equal((await fetch(strange)).status, 403);
// A picture of the folder is served, one outside of it neither by its path nor by a link.
const planted = [join(folder, "own.jpg"), join(folder, "../outside.jpg"), join(folder, "link.jpg")];
for (const file of planted.slice(0, 2))
    copyFileSync(picture, file);
symlinkSync("../outside.jpg", planted[2]);
for (const [name, status] of [["own.jpg", 200], ["..%2foutside.jpg", 404], ["link.jpg", 404]])
    assert.equal((await fetch(`${server.address}picture/${name}`)).status, status, name);
planted.forEach(file => rmSync(file));

// A model and a picture of one's own: the first look, then the preview.
let browser = await opened(server.address);
await shoot(browser, "empty");
// As fast as it can be, since the test is of the page.
await setting(browser, "texture.levels_count", 1);
await setting(browser, "texture.rounds_count", 1);
let begin = Date.now();
await drop(browser, model);
await until(browser, `view.has === "painting"`);
console.log(`a model dropped: its first look after ${Date.now() - begin} ms`);
await ready(browser, "preview");
const first = await browser.seen();
assert(first.part > 0.3, `the room fills ${first.part} of the canvas`);
// From now on there is something in sight: the first look is of that only.
await browser.evaluate(`{
    const glimpsed = view.glimpsed.bind(view);
    window.glimpses = [];
    view.glimpsed = async (...words) => { await glimpsed(...words); await new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done))); window.glimpses.push(${seenIn("#room canvas")}.sum); };
}`);
begin = Date.now();
await drop(browser, picture);
await until(browser, `chosen.picture === "sea_waves.jpg" && watched?.care === "preview" && !watched.end`);
console.log(`a second picture: seen after ${Date.now() - begin} ms`);
await ready(browser, "preview");
const second = await browser.seen();
const glimpses = await browser.evaluate("window.glimpses");
assert.equal(glimpses.length, 1);
assert(![first.sum, second.sum].includes(glimpses[0]));
assert.notEqual(second.sum, first.sum);

// The slider leads to the photo and back.
await browser.press("[");
await browser.press("[");
assert.notEqual((await browser.seen()).sum, second.sum);
await browser.press("]");
await browser.press("]");
assert.equal((await browser.seen()).sum, second.sum);

// A setting changes what is seen; emptied, it is as before.
await setting(browser, "texture.stroke_cm", 12);
await ready(browser, "preview");
assert.notEqual((await browser.seen()).sum, second.sum);
await setting(browser, "texture.stroke_cm", "");
await until(browser, `chosen.settings["texture.stroke_cm"] === undefined`);
await ready(browser, "preview");
assert.equal((await browser.seen()).sum, second.sum);

// A value out of range is refused in the words of the command line, at its setting.
await setting(browser, "texture.stroke_cm", 5000);
await browser.until(`document.querySelector(".setting .error")?.textContent.includes("stroke_cm")`);
await browser.evaluate(`document.getElementById("set-texture-stroke_cm").dispatchEvent(new KeyboardEvent("keydown", { key: "z", ctrlKey: true, bubbles: true }))`);
await until(browser, `chosen.settings["texture.stroke_cm"] === undefined`);
await ready(browser, "preview");

// Painting: progress, a second page that sees it, a change that shows afterwards, cancel, again.
await setting(browser, "atlas.size_px", 1024);
await ready(browser, "preview");
await browser.click("#paint");
await until(browser, `watched?.care === "full" && watched.stages.size > 0`);
const other = await opened(server.address);
await until(other, `watched?.care === "full" && !document.getElementById("progress").hidden`);
assert.equal(await other.evaluate(`document.getElementById("paint").disabled`), true);
await setting(browser, "texture.stroke_cm", 12);
await browser.evaluate("new Promise(done => setTimeout(done, 400))");
await other.click("#cancel");
await ready(browser, "preview");
await browser.click("#undo");
await ready(browser, "preview");
await until(browser, `!running && paintings[0].state === "canceled"`);
await other.close();
await browser.click("#paint");
await ready(browser, "painting");
await has(browser, "painting 2");
await until(browser, `paintings[0].thumbnail`);
const painted = await browser.seen();
await shoot(browser, "painted");

// From the store: the same again takes no painting.
begin = Date.now();
await browser.click("#paint");
await browser.until(`!document.getElementById("status").textContent.startsWith("painting")`);
await ready(browser, "painting");
console.log(`the same painting again: ${Date.now() - begin} ms`);
await has(browser, "painting 3");

// Back in history, and one deleted.
await browser.evaluate(`[...document.querySelectorAll("#history [data-name]")].find(button => button.dataset.name === "0002").click()`);
await has(browser, "painting 2");
await until(browser, `view.has === "painting"`);
assert.equal((await browser.seen()).sum, painted.sum);
await browser.evaluate(`(() => { const button = document.querySelector("#history .painting .remove"); button.click(); button.click(); })()`);
await until(browser, `paintings.length === 2`);

// Taken along.
await browser.click('[data-kind="glb"]');
assert.equal(await browser.download(), "room.glb");
const glb = readFileSync(join(saved, "room.glb"));
assert.equal(glb.toString("latin1", 0, 4), "glTF");
assert.equal(glb.readUInt32LE(8), glb.length);
await browser.click("#pipeline");
await browser.until(`document.querySelector("dialog pre").textContent.includes("base: model.yaml")`);
// The command as it stands finds every result in the store.
const command = (await browser.evaluate(`document.querySelector("dialog pre").textContent`)).split("\n$ ").slice(1).join(" && ");
const stored = execFileSync("bash", ["-c", command.replace(" fresco ", ` ${fresco} `) + " --json-log"], { encoding: "utf8" });
assert(!stored.includes('"event":"begin"'), stored);
await browser.click("dialog button");

// Pictures in the list: what was painted last, or else what the page draws of a model, of all of its primitives and nodes.
const pair = { at: 0, views: [] };
const block = values => { pair.views.push({ buffer: 0, byteOffset: pair.at, byteLength: values.byteLength }); pair.at += values.byteLength; return Buffer.from(values.buffer); };
const binary = Buffer.concat([block(Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0)), block(Uint16Array.of(0, 1, 2, 0))]);
const primitive = { attributes: { POSITION: 0 }, indices: 1 };
const json = Buffer.from(JSON.stringify({ asset: { version: "2.0" }, scenes: [{ nodes: [0] }], nodes: [{ children: [1, 2], scale: [2, 2, 2] }, { mesh: 0 }, { mesh: 0, translation: [0, 0, 1] }], meshes: [{ primitives: [primitive, primitive] }], buffers: [{ byteLength: pair.at }],
    bufferViews: pair.views, accessors: [{ bufferView: 0, componentType: 5126, count: 3, type: "VEC3", min: [0, 0, 0], max: [1, 1, 0] }, { bufferView: 1, componentType: 5123, count: 3, type: "SCALAR" }] }));
const text = Buffer.concat([json, Buffer.alloc((4 - json.length % 4) % 4, " ")]), sizes = Uint32Array.of(0x46546c67, 2, 28 + text.length + binary.length, text.length, 0x4e4f534a);
writeFileSync(join(folder, "pair.glb"), Buffer.concat([Buffer.from(sizes.buffer), text, Buffer.from(Uint32Array.of(binary.length, 0x4e4942).buffer), binary]));
writeFileSync(join(folder, "broken.glb"), "glTF");
await browser.evaluate(`window.dispatchEvent(new Event("focus"))`);
const shownOf = name => `document.querySelector('#scans [data-name="${name}"] img')?.getAttribute("src")`;
await until(browser, `${shownOf("pair.glb")}?.startsWith("blob:")`);
assert.match(await browser.evaluate(shownOf("room.glb")), /^painting\/0002\/thumb.jpg/);
assert.equal(await browser.evaluate(`document.querySelector('#scans [data-name="broken.glb"] .shape').textContent`), "GLB");
assert.deepEqual(await browser.evaluate(`fetch("run/pair.glb").then(answer => answer.arrayBuffer()).then(bytes => { const { triangles, low, extent } = roomOf(bytes); return [triangles, ...low, ...extent.slice(0, 2), extent[2]]; })`), [4, 0, 0, 0, 2, 2, 2]);
for (const name of ["pair.glb", "broken.glb"])
    rmSync(join(folder, name));

// Killed in the middle of a painting; the next one goes on with it.
await setting(browser, "texture.seed", 3);
await ready(browser, "preview");
await browser.click("#paint");
await until(browser, `watched?.care === "full" && watched.stages.get("texture")?.state === "running"`);
server.process.kill("SIGKILL");
await server.ended;
assert.deepEqual(browser.requests.filter(url => !url.startsWith(server.address) && !/^(blob|data):/.test(url) && url !== "about:blank"), []);
await browser.close();
server = await served();
browser = await opened(server.address);
// An older one that is looked at meanwhile stays.
const open = (page, id) => page.evaluate(`[...document.querySelectorAll("#history [data-name]")].find(button => button.dataset.name === "${id}").click()`);
await until(browser, `watched?.care === "full"`);
await open(browser, "0002");
await until(browser, `view.has === "painting"`);
await has(browser, "painting 2");
const old = await browser.seen();
await until(browser, `paintings.length === 3 && paintings[0].state === "done" && watched.over`);
await has(browser, "painting 2");
assert.equal((await browser.seen()).sum, old.sum);
await open(browser, "0003");
await has(browser, "painting 3");
assert.deepEqual(browser.problems.filter(problem => !problem.includes("GPU stall due to ReadPixels")), []);
// Results that are gone are made again.
rmSync(join(folder, ".fresco-studio/paintings/0003/out/view.glb"));
const late = await opened(server.address);
await late.until(`document.getElementById("problem").textContent.includes("are gone")`);
await late.click("#paint");
await ready(late, "painting");
// A run elsewhere that was killed is told; one that takes its place is watched from its beginning. Both go on since they began, not since they are watched.
const elsewhere = join(folder, "elsewhere"), log = join(elsewhere, "progress.jsonl");
const begun = stage => writeFileSync(log, `{"event":"stages","stages":[{"stage":"${stage}","state":"waiting","expected_s":60}]}\n{"event":"begin","stage":"${stage}","time_s":10}\n{"event":"progress","stage":"${stage}","done":1,"total":2,"unit":"rounds","time_s":30}\n`);
mkdirSync(elsewhere);
begun("photo");
await late.evaluate(`look().then(() => watchRun("elsewhere"))`);
await late.until(`document.getElementById("detail").textContent.includes("was killed")`);
assert(await late.evaluate(`watched.clock_s >= 30 && watched.left_s <= 40`));
// A past run that was shorter does not hide what is left of rounds.
assert(await late.evaluate(`watched.leftOf({ state: "running", expected_s: 3, begun: 0, began: 0, heard: watched.clock_s, first: 0, done: 2, total: 9, unit: "rounds" }) > 100`));
rmSync(log);
begun("texture");
await late.until(`document.getElementById("detail").textContent.startsWith("texture · 1 of 2 rounds")`);
await late.close();
const status = readFileSync(`/proc/${server.process.pid}/status`, "utf8");
console.log(`memory of the server: ${status.match(/VmHWM:\s*(\d+)/)[1]} kB`);
await browser.close();
server.process.kill("SIGTERM");
assert.equal(await server.ended, 0);

// The folder of another run is watched, by two at once, and stays as it is.
await served(dirname(model));
server = await served(dirname(model));
browser = await opened(server.address);
await has(browser, "result");
assert((await browser.seen()).part > 0.3);
await shoot(browser, "watched");
assert.equal((await fetch(`${server.address}api/paint`, { method: "POST", body: "{}" })).status, 403);
assert(!existsSync(join(dirname(model), ".fresco-studio")));
await browser.close();
process.exit(0);
