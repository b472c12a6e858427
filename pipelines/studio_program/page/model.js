// Models as the page shows them: the primitives of a glTF, with their places in the world, and a room as showRoom takes it.

const array_types = { 5120: Int8Array, 5121: Uint8Array, 5122: Int16Array, 5123: Uint16Array, 5125: Uint32Array, 5126: Float32Array };
const widths = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4 };

/// The chunks of a GLB: its JSON, and where its binary chunk begins.
function chunksOf(buffer) {
    const view = new DataView(buffer);
    if (buffer.byteLength < 20 || view.getUint32(0, true) !== 0x46546c67)
        throw new Error("this is not a GLB");
    const length = view.getUint32(12, true);
    return { json: JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 20, length))), at: 28 + length };
}

/// x, y, z turned by a quaternion.
function turned([x, y, z], [a, b, c, w]) {
    const [i, j, k] = [2 * (b * z - c * y), 2 * (c * x - a * z), 2 * (a * y - b * x)];
    return [x + w * i + b * k - c * j, y + w * j + c * i - a * k, z + w * k + a * j - b * i];
}

/// Visits a glTF's nodes that have a mesh: visit(node, matrix).
function eachMeshNode(json, visit) {
    const go = (index, above) => {
        const node = json.nodes[index], { matrix, translation = [0, 0, 0], rotation = [0, 0, 0, 1], scale = [1, 1, 1] } = node;
        const own = matrix ? new THREE.Matrix4().fromArray(matrix) : new THREE.Matrix4().compose(vector(translation), new THREE.Quaternion(...rotation), vector(scale));
        own.premultiply(above);
        if (node.mesh !== undefined)
            visit(node, own);
        (node.children ?? []).forEach(child => go(child, own));
    };
    (json.scenes?.[json.scene ?? 0]?.nodes ?? []).forEach(root => go(root, new THREE.Matrix4()));
}

/// The primitives of a glTF: [{places, corners, uvs, colors, tint, image, mode}], the places in the world; what it lacks is null. `buffers`: [{buffer, at}].
function primitivesOf(json, buffers) {
    const accessor = index => {
        const { bufferView, componentType, count, type, byteOffset = 0, sparse, normalized } = json.accessors[index];
        if (bufferView === undefined || sparse)
            throw new Error("this model is packed in a way that the page does not show");
        const { buffer = 0, byteOffset: begin = 0, byteStride } = json.bufferViews[bufferView], Kind = array_types[componentType];
        const width = widths[type], bytes = Kind.BYTES_PER_ELEMENT, stride = (byteStride ?? width * bytes) / bytes;
        const all = new Kind(buffers[buffer].buffer, buffers[buffer].at + begin + byteOffset, (count - 1) * stride + width);
        const values = stride === width ? all : new Kind(count * width);
        for (let i = 0; i < count && values !== all; ++i)
            values.set(all.subarray(i * stride, i * stride + width), i * width);
        return { values, width, unit: normalized ? 1 / (2 ** (8 * bytes - (Kind === Int8Array || Kind === Int16Array ? 1 : 0)) - 1) : 1 };
    };
    const parts = [];
    eachMeshNode(json, (node, { elements: m }) => {
        for (const { attributes, indices, material, mode = 4 } of json.meshes[node.mesh].primitives) {
            const { pbrMetallicRoughness: look = {} } = json.materials?.[material] ?? {}, picture = look.baseColorTexture ?? {};
            const { values, unit } = accessor(attributes.POSITION), places = new Float32Array(values.length);
            for (let i = 0; i < values.length; i += 3) {
                const [x, y, z] = [unit * values[i], unit * values[i + 1], unit * values[i + 2]];
                for (let axis = 0; axis < 3; ++axis)
                    places[i + axis] = m[axis] * x + m[4 + axis] * y + m[8 + axis] * z + m[12 + axis];
            }
            const list = name => attributes[name] === undefined ? null : accessor(attributes[name]);
            const scaled = found => found && Float32Array.from(found.values, value => value * found.unit);
            const harmonics = list("KHR_gaussian_splatting:SH_DEGREE_0_COEF_0"), colors = list("COLOR_0");
            const { source, extensions } = json.textures?.[picture.index] ?? {}, image = json.images?.[source ?? extensions?.EXT_texture_webp?.source];
            parts.push({
                places, mode, corners: indices === undefined ? Uint32Array.from({ length: places.length / 3 }, (_, i) => i) : Uint32Array.from(accessor(indices).values),
                uvs: scaled(list(`TEXCOORD_${picture.texCoord ?? 0}`)), tint: (look.baseColorFactor ?? [1, 1, 1]).slice(0, 3), image: image ?? null,
                colors: harmonics ? { values: harmonics.values.map(value => 0.5 + 0.2821 * value), width: 3 } : colors && { values: scaled(colors), width: colors.width },
            });
        }
    });
    return parts;
}

/// An image of a glTF as a blob; null: it is a file of its own.
function blobOf({ bufferView, mimeType }, json, buffers) {
    if (bufferView === undefined)
        return null;
    const { buffer = 0, byteOffset = 0, byteLength } = json.bufferViews[bufferView];
    return new Blob([new Uint8Array(buffers[buffer].buffer, buffers[buffer].at + byteOffset, byteLength)], { type: mimeType });
}

/// {low, extent, vertices, triangles, values, corners, picture, shape, rotation}: `picture` is a blob or null, that of most faces where there are several; `shape`
/// a number that rooms of equal geometry share; `rotation` that of the node of export.gltf.
function roomOf(buffer) {
    const { json, at } = chunksOf(buffer), buffers = [{ buffer, at }];
    const parts = primitivesOf(json, buffers).filter(({ mode }) => mode === 4);
    if (!parts.length)
        throw new Error("this GLB has no faces that the page could show");
    const faces = new Map();
    for (const { image, corners } of parts)
        faces.set(image, (faces.get(image) ?? 0) + corners.length * (image ? 1 : 0));
    const [image] = [...faces].sort((a, b) => b[1] - a[1])[0];
    const low = [Infinity, Infinity, Infinity], high = low.map(value => -value);
    for (const { places } of parts)
        for (let i = 0; i < places.length; ++i) {
            low[i % 3] = Math.min(low[i % 3], places[i]);
            high[i % 3] = Math.max(high[i % 3], places[i]);
        }
    const extent = low.map((value, axis) => Math.max(high[axis] - value, 1e-9));
    const sum = list => parts.reduce((all, part) => all + part[list].length, 0);
    const vertices = sum("places") / 3, values = new Uint16Array(6 * vertices), corners = new Uint32Array(sum("corners"));
    const step = share => Math.round(65535 * Math.max(0, Math.min(1, share)));
    let shape = vertices, vertex = 0, corner = 0;
    for (const { places, uvs, image: own, corners: list } of parts) {
        corners.set(vertex ? list.map(each => each + vertex) : list, corner);
        corner += list.length;
        for (let i = 0; i < places.length / 3; ++i, ++vertex) {
            for (let axis = 0; axis < 3; ++axis)
                values[6 * vertex + axis] = step((places[3 * i + axis] - low[axis]) / extent[axis]);
            if (uvs && own === image) {
                values[6 * vertex + 4] = step(uvs[2 * i]);
                values[6 * vertex + 5] = step(1 - uvs[2 * i + 1]);
            }
            for (let part = 0; part < 6; ++part)
                shape = (Math.imul(shape, 31) + values[6 * vertex + part]) | 0;
        }
    }
    return { low, extent, vertices, triangles: corners.length / 3, values, corners, picture: image && blobOf(image, json, buffers), shape, rotation: json.nodes.find(node => node.mesh === 0)?.rotation ?? [0, 0, 0, 1] };
}
