// three.mjs CHROMIUM FOLDER PLAIN.glb OTHER.glb…: three.js, unpacked in FOLDER/package, shows the same room in each file.
import assert from "node:assert/strict";
import { writeFileSync } from "node:fs";
import { join } from "node:path";
import { Browser, urlOf, webgl } from "../browser/browser.mjs";

const [program, folder, ...files] = process.argv.slice(2);
writeFileSync(join(folder, "show.html"), `<!doctype html><script type="importmap">{"imports": {"three": "./package/build/three.module.js"}}</script>
<script type="module">
import * as THREE from "three";
import { GLTFLoader } from "./package/examples/jsm/loaders/GLTFLoader.js";
window.pixels = async url => {
    const { scene } = await new GLTFLoader().loadAsync(url);
    scene.traverse(thing => { if (thing.material) thing.material = new THREE.MeshBasicMaterial({ map: thing.material.map }); });
    const box = new THREE.Box3().setFromObject(scene), middle = box.getCenter(new THREE.Vector3());
    const camera = new THREE.PerspectiveCamera(90, 1, 0.01, 100);
    camera.position.copy(middle);
    const renderer = new THREE.WebGLRenderer({ preserveDrawingBuffer: true });
    renderer.setSize(128, 128);
    const all = [];
    for (const [x, z] of [[1, 0], [0, 1], [-1, 0], [0, -1]]) {
        camera.lookAt(middle.x + x, middle.y, middle.z + z);
        renderer.render(scene, camera);
        const data = new Uint8Array(128 * 128 * 4), context = renderer.getContext();
        context.readPixels(0, 0, 128, 128, context.RGBA, context.UNSIGNED_BYTE, data);
        all.push(...data);
    }
    return all;
};
</script>`);
const browser = new Browser(program, webgl);
await browser.open();
await browser.load(urlOf(join(folder, "show.html")));
await browser.until(`typeof pixels === "function"`);
const shown = [];
for (const file of files)
    shown.push(await browser.evaluate(`pixels(${JSON.stringify(urlOf(file))})`));
const deviation = Math.sqrt(shown[0].reduce((sum, value) => sum + (value - 128) ** 2, 0) / shown[0].length);
assert(deviation > 20, "the room is not to be seen");
for (let i = 1; i < files.length; ++i) {
    const off = shown[i].reduce((sum, value, at) => sum + Math.abs(value - shown[0][at]), 0) / shown[i].length;
    console.log(`${files[i].split("/").at(-1)} in three.js: ${off.toFixed(2)} of 255 from ${files[0].split("/").at(-1)}`);
    assert(off < 4, `${files[i]} looks another way`);
}
await browser.close();
