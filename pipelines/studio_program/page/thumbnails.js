// Small pictures of models and splats that nobody has painted here yet. The page draws them itself, off screen, one after the other, and keeps them as
// long as it is open. Files beyond these limits, and those in formats that it does not read, keep their extension as a label.

const most_bytes = 24 << 20, most_drawn = 60, most_points = 50000, most_faces = 300000, most_ms = 20000;
const thumbnail_size = [208, 156];

async function smallFile(address) {
    const response = await fetch(address);
    if (!response.ok || Number(response.headers.get("content-length")) > most_bytes) {
        await response.body?.cancel();
        throw new Error("too large to be drawn");
    }
    return response.arrayBuffer();
}

const ply_types = { char: ["Int8", 1], int8: ["Int8", 1], uchar: ["Uint8", 1], uint8: ["Uint8", 1], short: ["Int16", 2], int16: ["Int16", 2], ushort: ["Uint16", 2], uint16: ["Uint16", 2],
    int: ["Int32", 4], int32: ["Int32", 4], uint: ["Uint32", 4], uint32: ["Uint32", 4], float: ["Float32", 4], float32: ["Float32", 4], double: ["Float64", 8], float64: ["Float64", 8] };

/// The columns of a PLY's elements by name, {vertex: {count, x: [...]}}; faces as corners of triangles, {face: {count, corners}}.
function plyOf(buffer) {
    const head = new TextDecoder("latin1").decode(new Uint8Array(buffer, 0, Math.min(buffer.byteLength, 65536)));
    const [header] = head.match(/^ply[^]*?\nend_header\r?\n/) ?? [];
    if (!header)
        throw new Error("this is not a PLY");
    const ascii = header.includes("format ascii"), little = !header.includes("binary_big_endian"), data = new DataView(buffer);
    const words = ascii ? new TextDecoder().decode(buffer).slice(header.length).trim().split(/\s+/) : [], elements = {};
    let at = ascii ? 0 : header.length;
    const size = ([, bytes]) => ascii ? 1 : bytes;
    const reader = ([kind]) => ascii ? place => Number(words[place]) : { get: data[`get${kind}`] }.get.bind(data);
    for (const part of header.split(/\nelement /).slice(1)) {
        const [first, ...lines] = part.split(/\r?\n/), [name, count] = first.split(" ");
        const properties = lines.map(line => line.trim().split(/\s+/)).filter(([word]) => word === "property").map(([, ...rest]) => [rest.at(-1), ...rest.slice(0, -1).filter(word => word !== "list").map(word => ply_types[word])]);
        if (name === "face" && Number(count) > most_faces)
            throw new Error("too many faces");
        const element = elements[name] = { count: Number(count) }, stride = properties.reduce((sum, [, type]) => sum + size(type), 0);
        if (properties.some(([, , inner]) => inner)) {
            element.corners = [];
            for (let row = 0; row < element.count; ++row)
                for (const [column, type, inner] of properties) {
                    const length = inner ? reader(type)(at, little) : 0, read = reader(inner ?? type);
                    at += size(type);
                    for (let i = 2; i < length && column.startsWith("vert"); ++i)
                        element.corners.push(read(at, little), read(at + (i - 1) * size(inner), little), read(at + i * size(inner), little));
                    at += inner ? length * size(inner) : 0;
                }
            continue;
        }
        for (const [column, type] of properties) {
            const read = reader(type), values = element[column] = new Float64Array(element.count);
            for (let row = 0; row < element.count; ++row)
                values[row] = read(at + row * stride, little);
            at += size(type);
        }
        at += (element.count - 1) * stride;
    }
    return elements;
}

const fan = corners => corners.slice(2).flatMap((corner, i) => [corners[0], corners[i + 1], corner]);
const shade = 0.2821;  // The harmonic of degree 0.
/// Three numbers of each of `count` points, or of some of very many: change(point, part).
const picked = (count, change) => {
    const step = Math.ceil(count / most_points), values = new Float32Array(3 * Math.floor(count / step));
    for (let i = 0; i < values.length; ++i)
        values[i] = change(step * Math.floor(i / 3), i % 3);
    return values;
};

/// The packed form of splats: 256 to a chunk, whose bounds come first.
function partsOfPacked({ chunk, vertex: { count, packed_position, packed_color } }) {
    const mixed = (name, point, share, low = 0, high = 1) => {
        const [from, to] = [chunk[`min_${name}`]?.[point >> 8] ?? low, chunk[`max_${name}`]?.[point >> 8] ?? high];
        return from + (to - from) * share;
    };
    const places = picked(count, (i, part) => mixed("xyz"[part], i, (packed_position[i] >>> [21, 11, 0][part] & [2047, 1023, 2047][part]) / [2047, 1023, 2047][part]));
    return [{ places, colors: { values: picked(count, (i, part) => mixed("rgb"[part], i, (packed_color[i] >>> 24 - 8 * part & 255) / 255)), width: 3 }, stands: true }];
}

function partsOfPly(buffer) {
    const elements = plyOf(buffer), { vertex, face } = elements, { count } = vertex;
    if (vertex.packed_position)
        return partsOfPacked(elements);
    if (vertex.f_dc_0)
        return [{ places: picked(count, (i, part) => vertex["xyz"[part]][i]), colors: { values: picked(count, (i, part) => 0.5 + shade * vertex[`f_dc_${part}`][i]), width: 3 } }];
    const whole = names => Float32Array.from({ length: 3 * count }, (_, i) => vertex[names[i % 3]][Math.floor(i / 3)]);
    const values = vertex.red && whole(["red", "green", "blue"]), most = values?.reduce((a, b) => Math.max(a, b), 0);
    return [{ places: whole(["x", "y", "z"]), corners: face?.count ? Uint32Array.from(face.corners) : null, colors: values && { values: most > 1 ? values.map(value => value / 255) : values, width: 3 }, stands: true }];
}

function partsOfObj(buffer) {
    const places = [], corners = [];
    for (const line of new TextDecoder().decode(buffer).split("\n")) {
        const [word, ...words] = line.trim().split(/\s+/);
        if (word === "v")
            places.push(...words.slice(0, 3).map(Number));
        else if (word === "f")
            corners.push(...fan(words.map(each => parseInt(each, 10)).map(at => at < 0 ? at + places.length / 3 : at - 1)));
    }
    return [{ places: Float32Array.from(places), corners: Uint32Array.from(corners), stands: true }];
}

/// Records of 32 bytes: place, size, color, rotation.
function partsOfSplat(buffer) {
    const count = Math.floor(buffer.byteLength / 32), numbers = new Float32Array(buffer, 0, 8 * count), bytes = new Uint8Array(buffer);
    return [{ places: picked(count, (i, part) => numbers[8 * i + part]), colors: { values: picked(count, (i, part) => bytes[32 * i + 24 + part] / 255), width: 3 } }];
}

async function partsOfSpz(packed) {
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
    const buffer = await new Response(stream).arrayBuffer(), bytes = new Uint8Array(buffer);
    const count = new DataView(buffer).getUint32(8, true), unit = 2 ** -bytes[13], colors_at = 16 + 10 * count;
    const whole = at => (bytes[at] | bytes[at + 1] << 8 | bytes[at + 2] << 16) << 8 >> 8;
    const values = picked(count, (i, part) => 0.5 + shade * (bytes[colors_at + 3 * i + part] / 255 - 0.5) / 0.15);
    return [{ places: picked(count, (i, part) => unit * whole(16 + 9 * i + 3 * part)), colors: { values, width: 3 }, stands: true }];
}

async function partsOfGltf(file, address) {
    const bytes = await smallFile(address);
    const { json, at } = file.endsWith(".glb") ? chunksOf(bytes) : { json: JSON.parse(new TextDecoder().decode(bytes)), at: 0 };
    const beside = uri => uri.startsWith("data:") ? bytesOf(uri.slice(uri.indexOf(",") + 1)) : smallFile(new URL(uri, new URL(address, location.href)));
    const buffers = await Promise.all((json.buffers ?? []).map(async ({ uri }) => uri === undefined ? { buffer: bytes, at } : { buffer: await beside(uri), at: 0 }));
    const parts = primitivesOf(json, buffers).filter(({ mode }) => mode === 4 || mode === 0);
    for (const part of parts) {
        const picture = part.image && part.uvs && (blobOf(part.image, json, buffers) ?? new Blob([await beside(part.image.uri)]));
        Object.assign(part, { corners: part.mode ? part.corners : null, stands: true });
        if (!picture)
            continue;
        const bitmap = await createImageBitmap(picture, { imageOrientation: "none", resizeWidth: 256, resizeHeight: 256 });
        part.texture = new THREE.CanvasTexture(Object.assign(document.createElement("canvas"), { width: 256, height: 256 }));
        part.texture.image.getContext("2d").drawImage(bitmap, 0, 0);
        Object.assign(part.texture, { flipY: false, wrapS: THREE.RepeatWrapping, wrapT: THREE.RepeatWrapping });
    }
    return parts;
}

async function partsAt(name) {
    const address = `run/${addressOf(name)}`, file = name.toLowerCase();
    if (/\.gl(b|tf)$/.test(file))
        return partsOfGltf(file, address);
    const read = { ply: partsOfPly, obj: partsOfObj, splat: partsOfSplat, spz: partsOfSpz }[file.split(".").at(-1)];
    if (!read)
        throw new Error("not in a format that the page draws");
    return read(await smallFile(address));
}

function drawable({ places, corners, colors, uvs, texture, tint = [1, 1, 1] }) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(places, 3));
    if (colors)
        geometry.setAttribute("color", new THREE.BufferAttribute(colors.width === 3 ? colors.values : colors.values.filter((_, i) => i % 4 < 3), 3));
    const look = { vertexColors: colors ? THREE.VertexColors : THREE.NoColors };
    if (!corners)
        return new THREE.Points(geometry, new THREE.PointsMaterial({ ...look, size: 2, sizeAttenuation: false }));
    geometry.setIndex(new THREE.BufferAttribute(corners, 1));
    if (texture)
        geometry.setAttribute("uv", new THREE.BufferAttribute(uvs, 2));
    return new THREE.Mesh(geometry, colors || texture || tint.some(value => value < 0.99) ? new THREE.MeshBasicMaterial({ ...look, map: texture ?? null, color: new THREE.Color(...tint) }) : clay());
}

/// From above and beside, with the crumbs far off out of the picture. Most splats that have no header of their own for it have y down.
function cameraFor(parts) {
    const points = parts.flatMap(({ places }) => {
        const step = 3 * Math.ceil(places.length / 3 / (20000 / parts.length));
        return Array.from({ length: Math.floor(places.length / step) }, (_, i) => vector(places.subarray(step * i, step * i + 3)));
    });
    const out = points.length < 100 ? 0 : 0.03, down = parts[0].stands ? 1 : -1;
    const middle = vector(["x", "y", "z"].map(axis => [out, 1 - out].reduce((sum, share) => sum + quantile(points.map(point => point[axis]), share) / 2, 0)));
    const reach = Math.max(1e-9, quantile(points.map(point => point.distanceTo(middle)), 1 - out));
    const camera = new THREE.PerspectiveCamera(35, thumbnail_size[0] / thumbnail_size[1], reach / 100, reach * 20);
    camera.up.set(0, down, 0);
    camera.position.copy(vector([0.6, 0.55 * down, 0.72]).normalize().multiplyScalar(reach * 3.2).add(middle));
    camera.lookAt(middle);
    return camera;
}

/// Pictures by the names of files: `at(name)` gives an address, or null while there is none. `changed(name, address)` is called with each new one.
class Thumbnails {
    constructor(changed) {
        Object.assign(this, { changed, found: new Map(), waiting: [], busy: false });
    }

    at(name) {
        if (!this.found.has(name) && this.found.size < most_drawn) {
            this.found.set(name, null);
            this.waiting.push(name);
            this.work();
        }
        return this.found.get(name) ?? null;
    }

    async work() {
        if (this.busy)
            return;
        this.busy = true;
        const renderer = new THREE.WebGLRenderer({ antialias: true, alpha: true, preserveDrawingBuffer: true }), begin = performance.now();
        renderer.setSize(...thumbnail_size, false);
        for (let name = this.waiting.shift(); name !== undefined; name = this.waiting.shift()) {
            await new Promise(done => setTimeout(done, 50));  // The page stays usable meanwhile.
            if (performance.now() - begin > most_ms)
                continue;
            try {
                this.found.set(name, await this.drawn(renderer, name));
                this.changed(name, this.found.get(name));
            } catch {
                // It keeps its label.
            }
        }
        renderer.forceContextLoss();
        renderer.dispose();
        this.busy = false;
    }

    async drawn(renderer, name) {
        const parts = await partsAt(name), scene = new THREE.Scene();
        if (!parts.some(({ places }) => places.length) || parts.reduce((sum, { corners }) => sum + (corners?.length ?? 0), 0) > 3 * most_faces)
            throw new Error("nothing, or too much to draw");
        scene.add(...parts.map(drawable));
        renderer.render(scene, cameraFor(parts));
        for (const { geometry, material } of scene.children) {
            geometry.dispose();
            material.map?.dispose();
            material.dispose();
        }
        return URL.createObjectURL(await new Promise(resolve => renderer.domElement.toBlob(resolve)));
    }
}
