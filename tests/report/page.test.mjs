// page.test.mjs FOLDER…: what the scripts of pages make of data, without a browser. FOLDER: framework/report, plugins/shared/page/viewer
// and plugins/view/artifacts/report.
import assert from "node:assert/strict";
import { readFileSync, readdirSync } from "node:fs";
import { createContext, runInContext } from "node:vm";

const scripts = process.argv.slice(2).flatMap(folder => readdirSync(folder).filter(name => name.endsWith(".js")).map(name => readFileSync(`${folder}/${name}`, "utf8")));
const names = ["figureText", "bytesText", "durationText", "addressOf", "figuresOf", "layoutOf", "placesOf", "roundTicks", "axesOf", "smoothed", "barsOf", "upOf", "viewsOf", "figureTables", "shellWord",
    "inputsOf", "unpacked", "planOf", "roomAt", "stepFrom", "widestPlace", "floorOf"];
const page = runInContext(`"use strict";\n${scripts.join("\n")}\n({ ${names.join(", ")} })`, createContext({ atob }));
/// Objects of the scripts' own realm as ours.
const plain = value => JSON.parse(JSON.stringify(value));
const equal = (found, expected) => assert.deepEqual(plain(found), expected);

// Figures in words, with what was before beside what is now.
for (const [number, text] of [[1234, "1234"], [-12345, "−12\u202f345"], [0.000123456, "0.0001235"], [1234.56, "1235"], [2.5, "2.5"], [813175, "813\u202f175"]])
    assert.equal(page.figureText(number), text);
for (const [bytes, text] of [[999, "999 bytes"], [12_345_678, "12.3 MB"], [3_100, "3.1 kB"], [5e12, "5000.0 GB"]])
    assert.equal(page.bytesText(bytes), text);
for (const [seconds, text] of [[4.06, "4.1 s"], [41.2, "41 s"], [65, "1:05 min"], [3723, "1:02:03 h"]])
    assert.equal(page.durationText(seconds), text);
const figures = page.figuresOf({
    faces_before: 813175, area_m2_before: 2, faces_after: 499995, area_m2_after: 8, used_share: 0.3188, texels_per_cm: 1.09, largest_angle_deg: 70,
    bytes: 9071468, list: [1, 2], losses: { style: 1.5, content: null }, below_after: 3, judged_frames: { least: 150 }, table: { columns: ["a"] }, good: true,
});
equal(figures.map(({ label, value, before, change }) => [label, before, value, change].join("|")), [
    "faces|813\u202f175|499\u202f995|−38.5 %", "area|2 m²|8 m²|×4", "used||31.88 %|", "texels per cm||1.09|", "largest angle||70 °|", "bytes||9.1 MB|",
    "losses style||1.5|", "losses content||not finite|", "below after||3|", "good||yes|"]);

// Nothing in a name is taken for a scheme, a query or markup.
assert.equal(page.addressOf("a b/50%.png"), "./a%20b/50%25.png");
assert.equal(page.addressOf("javascript:alert(1)"), "./javascript%3Aalert(1)");
assert.equal(page.addressOf("é?#.png"), "./%C3%A9%3F%23.png");
assert.equal(["fresco", "a b", "it's"].map(page.shellWord).join(" "), "fresco 'a b' 'it'\\''s'");

// Stages are drawn behind what they wait for, and no two in one place. scan feeds all; views waits for the longest way.
const stage = (name, ...from) => ({ name, state: "ran", inputs: [...from.map(stage => ({ stage })), { file: "picture.png" }] });
const drawing = page.layoutOf([stage("scan"), stage("mesh", "scan"), stage("atlas", "mesh", "scan"), stage("views", "atlas", "scan", "scan")]);
equal(drawing.layers.length, 4);
equal(drawing.boxes.slice(0, 4).map(({ layer }) => layer), [0, 1, 2, 3]);
assert.equal(drawing.ways.length, 5);
assert.equal(drawing.boxes.length, 4 + 1 + 2);  // scan → atlas passes one layer, scan → views two.
assert.equal(new Set(drawing.boxes.map(({ layer, row }) => `${layer}/${row}`)).size, drawing.boxes.length);
for (const way of drawing.ways)
    way.slice(1).forEach((to, i) => assert.equal(drawing.boxes[way[i]].layer + 1, drawing.boxes[to].layer));
equal(page.layoutOf([]), { boxes: [], ways: [], layers: [] });
const { places } = page.placesOf(drawing);
assert.equal(new Set(places.map(({ x, y }) => `${x}/${y}`)).size, drawing.boxes.length);
assert.equal(places[0].y, places[3].y);
// Many layers are narrower, so that the page holds them.
for (const [count, most] of [[4, 800], [9, 1190], [11, 1190]]) {
    const row = Array.from({ length: count }, (_, i) => stage(`s${i}`, ...(i ? [`s${i - 1}`] : [])));
    const { width, own, bend } = page.placesOf(page.layoutOf(row));
    assert(width <= most && own >= 80 && bend >= 8, `${count} layers: ${width}, ${own}, ${bend}`);
}
  // Alone in their layers: in the middle.

// Axes.
equal(page.roundTicks(0, 10, 5), [0, 2, 4, 6, 8, 10]);
assert.equal(page.roundTicks(-0.3, 0.31, 3).length, 3);
equal(page.roundTicks(4, 4, 3), [4]);
assert(page.roundTicks(1e17, 1e17 + 16, 4).length <= 5);  // The whole numbers between are no doubles.
const axes = page.axesOf([[1, 100], [2, 10], [3, 1]]);
assert.equal(axes.y(10), (axes.y(100) + axes.y(1)) / 2);  // Logarithmic: half way down.
equal(axes.rows, [1, 10, 100]);
const flat = page.axesOf([[0, 5], [1, 5]]);
assert(Number.isFinite(flat.y(5)) && Number.isFinite(flat.x(1)));
equal(page.smoothed([1, 2, 3]), [1, 2, 3]);
assert.equal(page.smoothed(Array.from({ length: 80 }, (_, i) => i % 2)).at(40), 2 / 5);

// A bar per frame, or per few frames the largest.
equal(page.upOf([{ figures: { up: [0, 1, 0] } }, { figures: { up: [0, 0, 1] } }, { figures: { up: "z" } }]), [0, 0, 1]);
assert.equal(page.upOf([{ figures: {} }]), undefined);
const judged = { measure: "sharpness", least: 150, names: ["s/a", "s/b", "s/c"], values: [300, 100, 200], kept: [true, false, false] };
equal(page.barsOf(judged).bars.map(({ verdict }) => verdict), ["kept", "beyond", "dropped"]);
equal(page.barsOf({ ...judged, least: undefined, most: 150, values: [100, 200, 120] }).bars.map(({ verdict }) => verdict), ["kept", "beyond", "dropped"]);
equal(page.barsOf({ ...judged, beyond: [false, false, true] }).counts, { kept: 1, beyond: 1, dropped: 1 });
equal(page.barsOf({ ...judged, beyond: [false, false, true] }).bars.map(({ verdict }) => verdict), ["kept", "dropped", "beyond"]);
assert.equal(page.barsOf({ ...judged, values: [] }), null);
assert.equal(page.barsOf({}), null);
const many = page.barsOf({ names: Array(5000).fill("frame"), values: Array.from({ length: 5000 }, (_, i) => i), kept: Array(5000).fill(true) });
equal([many.bars.length, many.bars[0].value, many.counts.kept], [1000, 4, 5000]);

// A combination shows the pictures that only some read.
const read = (name, ...files) => ({ name, inputs: [{ stage: "scan" }, ...files.map(file => ({ file }))] });
const painted = { stages: [read("texture@a", "/a.png", "/all.png"), read("texture@b", "/b.png", "/all.png"), read("mesh", "/m.ply")],
    combinations: [{ name: "a", stages: ["mesh", "texture@a"] }, { name: "b", stages: ["mesh", "texture@b"] }] };
const small = ["/a.png", "/b.png", "/all.png"].map(file => ({ file, port: "style", pictures: [{ uri: `data:${file}` }] }));
equal([...page.inputsOf(painted, [...small, { stage: "views", folder: "" }])], [["a", [{ port: "style", file: "/a.png", uri: "data:/a.png" }]],
    ["b", [{ port: "style", file: "/b.png", uri: "data:/b.png" }]]]);
equal([...page.inputsOf({ ...painted, combinations: painted.combinations.slice(1) }, small)][0][1].map(({ file }) => file), ["/b.png", "/all.png"]);

// The slider compares what the stage with the most pictures of recorded frames made.
const pictures = (...all) => all.map(name => ({ name, uri: `data:image/jpeg,${name}`, pose: name }));
const views = page.viewsOf([{ stage: "frames", cameras: {}, pictures: pictures("s_1", "s_2") }, { stage: "one", folder: "", pictures: pictures("s_1.png") },
    { stage: "two", folder: "x", pictures: pictures("v/s_2.jpg", "v/other.jpg", "v/s_1.jpg") }]);
equal([views.entry.stage, views.views.map(({ name, pose }) => `${name} ${pose}`)], ["two", ["s_2 s_2", "s_1 s_1"]]);
equal(page.viewsOf([]).views, []);

// Of a matrix, the figures in which combinations differ.
const swept = (name, own_name, figures) => ({ name, own_name, figures });
equal(page.figureTables({
    stages: [swept("scan", "scan", { frames: 3 }), swept("paint@a", "paint", { losses: { style: 1 }, size_px: 8 }), swept("paint@b", "paint", { losses: { style: 2.5 }, size_px: 8 })],
    combinations: [{ name: "a", stages: ["scan", "paint@a"] }, { name: "b", stages: ["scan", "paint@b"] }],
}), [{ stage: "paint", labels: ["losses style"], rows: [["a", "1"], ["b", "2.5"]] }]);
// Two faces as the SDK packs them: an edge in common, the differences of values to the corner before.
const packed = Buffer.from([0, 0, 0, 0, 0, 0, 0, 2, 3, 200, 1, 0, 0, 0, 4, 0, 0, 0, 0, 3, 1, 0, 1, 0, 0, 0, 0]);
const mesh = page.unpacked({ vertices: 4, triangles: 2, geometry: packed.toString("base64") });
equal(Array.from(mesh.corners), [0, 1, 2, 0, 2, 3]);
equal(Array.from(mesh.values), [0, 0, 0, 0, 0, 0, 1, 65534, 100, 0, 0, 0, 3, 65534, 100, 0, 0, 0, 2, 65534, 100, 0, 0, 0]);

// A room of 4 m x 3 m, 2.5 m high, with a gap of 30 cm in its east wall and a table in the middle of its western half.
const quad = (a, b, c, d) => [[a, b, c], [a, c, d]];
const wall = ([x0, y0], [x1, y1]) => quad([x0, y0, 0], [x1, y1, 0], [x1, y1, 2.5], [x0, y0, 2.5]);
const faces = [quad([0, 0, 0], [4, 0, 0], [4, 3, 0], [0, 3, 0]), quad([0.7, 1.2, 0.75], [1.3, 1.2, 0.75], [1.3, 1.8, 0.75], [0.7, 1.8, 0.75]), quad([0, 0, 2.5], [0, 3, 2.5], [4, 3, 2.5], [4, 0, 2.5]),
    wall([0, 0], [4, 0]), wall([4, 0], [4, 1.35]), wall([4, 1.65], [4, 3]), wall([4, 3], [0, 3]), wall([0, 3], [0, 0])].flat();
const triangles = visit => faces.forEach(face => visit(...face));
assert(Math.abs(page.floorOf(triangles, 0, 2.5)) < 0.03);
const plan = page.planOf(triangles, [0, 0], [4, 3], 1.6);
assert(page.roomAt(plan, 2, 1.5) > 0.5);
assert(page.roomAt(plan, 1, 1.5) > 0.5);  // The eye is above the table.
assert(page.roomAt(plan, 0.1, 1.5) < 0);
assert(page.roomAt(plan, -2, 1.5) < page.roomAt(plan, -1, 1.5) && page.roomAt(plan, -1, 1.5) < page.roomAt(plan, 0.1, 1.5));
const walked = (from, [east, north], steps) => {
    let at = from;
    for (let i = 0; i < steps; ++i)
        at = page.stepFrom(plan, at, [east, north]);
    return at;
};
const stopped = walked([2, 0.8], [-0.04, 0], 200);
assert(stopped[0] > 0.15 && stopped[0] < 0.45 && stopped[1] === 0.8, `at the wall: ${stopped}`);
const slid = walked([2, 0.8], [-0.04, 0.02], 200);
assert(slid[0] < 0.45 && slid[1] > 2.5 && slid[1] < 2.9, `along the wall: ${slid}`);
assert(walked([2, 1.5], [0.04, 0], 200)[0] < 4, "through the gap");
assert(walked([0.1, 1.5], [0.04, 0], 100)[0] > 3, "stuck near a wall");
assert(walked([-1, 1.5], [-0.04, 0], 50)[0] > -1.1, "farther out from outside");
assert(walked([-1, 1.5], [0.04, 0], 100)[0] > 0, "stuck outside");
const { place, angle } = page.widestPlace(plan);
assert(Math.abs(place[0] - 2) < 0.7 && Math.abs(place[1] - 1.5) < 0.2, `the widest place: ${place}`);
assert(Math.abs(Math.sin(angle)) < 0.6, `the first view is ${angle}, across the room`);
// Where a wall was not scanned, the end of the floor counts as one.
const open = page.planOf(visit => faces.filter(face => face.some(([, north]) => north > 0)).forEach(face => visit(...face)), [0, 0], [4, 3], 1.6);
assert(Math.abs(page.widestPlace(open).place[1] - 1.5) < 0.3, "the widest place is at the open side");
// Nor does one look out there, although that view is the longest.
const half = page.planOf(visit => faces.filter(face => face.some(([east]) => east < 4)).forEach(face => visit(...face)), [0, 0], [4, 3], 1.6);
const ahead = page.widestPlace(half).angle;
assert(Math.cos(ahead) < 0.85, `the first view is ${ahead}, out of the room`);
const none = page.planOf(() => {}, [0, 0], [1, 1], 1.6);
assert.equal(page.widestPlace(none), null);
assert(page.roomAt(none, 0.5, 0.5) < 0);
console.log("the scripts of the pages: all well");
