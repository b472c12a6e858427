// usdz.mjs TINYUSDZ ROOM.obj UNLIT.usdz LIT.usdz: the packages by a reader of USD that shares nothing with the writer; they must hold the room that
// the OBJ file holds. TINYUSDZ: the folder of the npm package.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";

const [folder, obj, ...packages] = process.argv.slice(2);
const node = process;
const files = packages.map(file => new Uint8Array(readFileSync(file)));
const wasmBinary = readFileSync(`${folder}/tinyusdz.wasm`);
// It believes to be in a browser, the only place that it was built for.
globalThis.window = globalThis;
globalThis.process = undefined;
const { default: init } = await import(pathToFileURL(resolve(`${folder}/tinyusdz.js`)).href);
const reader = await init({ wasmBinary });
globalThis.process = node;

/// Nine coordinates per face, and six of its texcoords.
function facesOfObj(text) {
    const lists = { v: [], vt: [], f: [] };
    for (const [name, ...words] of text.split("\n").map(line => line.trim().split(/\s+/)))
        lists[name]?.push(words.map(word => word.split("/").map(Number)));
    const rows = (list, part, width) => lists.f.map(face => face.flatMap(corner => list[corner[part] - 1].flat().slice(0, width)));
    return { points: rows(lists.v, 0, 3), texcoords: rows(lists.vt, 1, 2) };
}

const largest = (a, b) => {
    assert.equal(a.length, b.length);
    return a.reduce((most, row, i) => row.reduce((m, value, j) => Math.max(m, Math.abs(value - b[i][j])), most), 0);
};

const expected = facesOfObj(readFileSync(obj, "utf8"));
for (const [i, is_lit] of [false, true].entries()) {
    const usd = new reader.TinyUSDZLoaderNative();
    assert(usd.loadFromBinary(files[i], "room.usdz"), usd.error());
    assert.equal(usd.numMeshes(), 1);
    const root = usd.getDefaultRootNode();
    assert.equal(root.primName, "room");
    const mesh = usd.getMesh(0);
    assert(mesh.faceVertexCounts.every(count => count === 3));
    const of_corner = (values, width, vertex) => Array.from(values.slice(width * vertex, width * (vertex + 1)));
    const per_face = (values, width) => Array.from(mesh.faceVertexCounts, (_, face) =>
        [0, 1, 2].flatMap(corner => of_corner(values, width, mesh.faceVertexIndices[3 * face + corner])));
    const points = per_face(mesh.points, 3);
    assert(largest(points, expected.points) < 1e-6);
    // The node puts the middle of its box above the origin, and its lowest point level with it.
    const moved = points.flatMap(row => [0, 3, 6].map(at => row.slice(at, at + 3).map((value, axis) => value + root.localMatrix[12 + axis])));
    for (const [axis, low] of [[0, null], [1, 0], [2, null]]) {
        const ends = moved.reduce(([a, b], point) => [Math.min(a, point[axis]), Math.max(b, point[axis])], [Infinity, -Infinity]);
        assert(Math.abs(low === null ? ends[0] + ends[1] : ends[0] - low) < 2e-3, `axis ${axis}: ${ends}`);
    }
    const material = usd.getMaterial(mesh.materialId);
    const texture = usd.getTexture(is_lit ? material.diffuseColorTextureId : material.emissiveColorTextureId);
    assert.deepEqual([texture.wrapS, texture.wrapT, material.metallic, material.roughness], ["clamp_to_edge", "clamp_to_edge", 0, 1]);
    const image = usd.getImage(texture.textureImageId);
    assert.equal(image.usdColorSpace, "srgb");
    assert(image.data.length > 1000);
    // It reads texcoords only where a diffuse color needs them.
    if (is_lit)
        assert(largest(per_face(mesh.texcoords, 2), expected.texcoords) < 1e-6);
    else
        assert.deepEqual(material.diffuseColor, [0, 0, 0]);
    console.log(`tinyusdz reads ${is_lit ? "lit" : "unlit"}: ${points.length} faces, ${mesh.points.length / 3} vertices, ${image.uri}`);
}
