// stylemesh.mjs CHROMIUM FRESCO FOLDER SHALLOW WEIGHTS [SCREENSHOTS]: StyleMesh in fresco studio, on the recording that FOLDER has: chosen, painted,
// stopped and kept, killed meanwhile, and watched from elsewhere. SHALLOW: weights that end too early.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { copyFileSync, existsSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { has, ready, setting, studioIn, until } from "./page.mjs";

const [program, fresco, folder, shallow, weights, screenshots] = process.argv.slice(2);
const { served, opened, shoot } = studioIn(folder, program, fresco, screenshots);
const stylemesh = `[...document.querySelectorAll("#set-method button")].at(-1)`;
const painting = id => join(folder, ".fresco-studio/paintings", id);
const read = (id, name) => readFileSync(join(painting(id), name), "utf8");
const step = `Number(/^texture · step (\\d+) of/.exec(document.getElementById("detail").textContent)?.[1] ?? 0)`;
/// What the server says to a request; the error, if it refuses.
const asked = async (server, path, body = {}) => (await (await fetch(server.address + path, { method: "POST", body: JSON.stringify(body) })).json()).error ?? "";

// Without weights, or with too few, StyleMesh cannot be chosen, and the page says what it needs.
let server = await served();
let browser = await opened(server.address);
await until(browser, `${stylemesh}.title.includes("fresco weights get vgg19")`);
assert.equal(await browser.evaluate(`${stylemesh}.disabled`), true);
copyFileSync(shallow, join(folder, "shallow.safetensors"));
await browser.evaluate(`window.dispatchEvent(new Event("focus"))`);
await until(browser, `${stylemesh}.title.includes("shallow.safetensors ends at conv3_1")`);
const settings = { method: "stylemesh" };
const request = { scan: "room", picture: "shipped/sea_waves.jpg", settings, care: "full" };
assert.match(await asked(server, "api/paint", request), /ends at conv3_1/);
assert.match(await asked(server, "api/keep"), /no painting is being made/);

// Brush strokes grow in sight, and cannot be kept before they are done.
await setting(browser, "atlas.size_px", 4096);
await setting(browser, "texture.rounds_count", 30);
await until(browser, `chosen.scan === "room"`);
await browser.click("#paint");
await has(browser, "as it grows");
assert.equal(await browser.evaluate(`document.getElementById("keep").hidden`), true);
assert.match(await asked(server, "api/keep"), /only StyleMesh/);
await browser.click("#cancel");
await until(browser, `!running && paintings[0].state === "canceled"`);
await browser.close();
server.process.kill("SIGTERM");
assert.equal(await server.ended, 0);

server = await served(folder, "--weights", weights);
browser = await opened(server.address);
await until(browser, `!${stylemesh}.disabled`);
await until(browser, `chosen.scan === "room"`);
await setting(browser, "texture.stroke_cm", 9);
await browser.evaluate(`${stylemesh}.click()`);
await until(browser, `document.getElementById("status").textContent.startsWith("StyleMesh has no preview")`);
await has(browser, "photo");
assert.deepEqual(await browser.evaluate("chosen.settings"), settings);
const photo = await browser.seen();
assert(photo.part > 0.3);
await shoot(browser, "stylemesh");

// It grows in sight, step by step, and is kept as it is; the page then has the step among the settings.
await setting(browser, "atlas.size_px", 1024);
await browser.click("#paint");
await until(browser, `watched?.care === "full" && !document.getElementById("keep").hidden`);
await until(browser, `document.getElementById("keep").disabled`);
assert.match(await asked(server, "api/keep"), /has not made its first step/);
await has(browser, "as it grows");
await until(browser, `${step} > 1`);
assert.notEqual((await browser.seen()).sum, photo.sum);
await shoot(browser, "stylemesh_grows");
await browser.press("k");
await ready(browser, "painting");
await has(browser, "painting 2");
const kept = await browser.evaluate(`chosen.settings["texture.stop_at_step"]`);
assert(kept > 1);
assert(read("0002", "painting.yaml").includes(`stop_at_step: ${kept}`));
assert(!existsSync(join(painting("0002"), "keep")));
assert.equal(await browser.evaluate(`document.querySelector("#history .stopped").textContent`), `stopped at step ${kept}`);
assert.equal(await browser.evaluate(`document.getElementById("set-texture-stop_at_step").value`), `${kept}`);
assert(read("0002", "log.jsonl").includes(`going on after step ${kept} of ${kept}`));
await until(browser, `paintings[0].thumbnail`);
await shoot(browser, "stylemesh_kept");
// The values that the page shows are those of the pipeline.
const checked = spawn(fresco, ["check", join(painting("0002"), "painting.yaml"), "--json"], { stdio: ["ignore", "pipe", "inherit"] });
let report = "";
for await (const data of checked.stdout)
    report += data;
const { options } = JSON.parse(report).stages.find(({ name }) => name === "texture");
for (const name of ["theta_d_m", "epochs", "repeats_count", "init", "angle_limit_deg", "lambda_r", "rate", "seed"])
    assert.equal(await browser.evaluate(`document.getElementById("set-texture-${name}").value`), `${options[name]}`, name);
await browser.click("#pipeline");
await browser.until(`document.querySelector("dialog pre").textContent.includes("stop_at_step: ${kept}")`);
await browser.click("dialog button");
await browser.click('[data-kind="glb"]');
assert.equal(await browser.download(), "room.glb");

// Killed as soon as it was asked for: the next one keeps it.
await setting(browser, "texture.stop_at_step", "");
await setting(browser, "texture.seed", 1);
await browser.click("#paint");
await until(browser, `watched?.care === "full" && ${step} > 0`);
assert.equal(await asked(server, "api/keep"), "");
server.process.kill("SIGKILL");
await server.ended;
await browser.close();
server = await served(folder, "--weights", weights);
browser = await opened(server.address);
await until(browser, `watched?.stages.get("texture")?.state === "running" || paintings[0]?.state === "done"`);
await until(browser, `paintings[0].id === "0003" && paintings[0].request.settings["texture.stop_at_step"] > 0`);
await until(browser, `paintings[0].state === "done"`);
assert.match(read("0003", "painting.yaml"), /stop_at_step: [1-9]/);
assert.deepEqual(browser.problems.filter(problem => !problem.includes("GPU stall due to ReadPixels")), []);
await browser.close();
server.process.kill("SIGTERM");
assert.equal(await server.ended, 0);

// The whole run, begun elsewhere: it goes on from the same steps, and its folder is watched.
const live = join(folder, "../live");
const run = spawn(fresco, ["run", join(painting("0002"), "painting.yaml"), "--store", join(folder, ".fresco-studio/store"), "--out", live,
    "--set", "texture.stop_at_step=0", "--quiet"], { stdio: "inherit" });
process.on("exit", () => run.kill("SIGKILL"));
const over = new Promise(resolve => run.on("exit", resolve));
while (!existsSync(join(live, "progress.jsonl")))
    await new Promise(resolve => setTimeout(resolve, 20));
server = await served(live);
browser = await opened(server.address);
await until(browser, `watched?.stages.get("texture")?.state === "running"`);
await until(browser, `${step} > ${kept}`);
await until(browser, `document.getElementById("newest").naturalWidth > 0 && !document.getElementById("newest").hidden`);
assert.equal(await browser.evaluate(`document.getElementById("cancel").hidden && document.getElementById("keep").hidden`), true);
await shoot(browser, "stylemesh_watched");
run.kill("SIGTERM");
assert.equal(await over, 75);
assert(!existsSync(join(live, ".fresco-studio")));
await browser.close();
process.exit(0);
