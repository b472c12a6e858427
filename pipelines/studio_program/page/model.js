// A GLB as export.gltf writes it: one mesh, one picture. It becomes a room as showRoom takes it.

const array_types = { 5121: Uint8Array, 5123: Uint16Array, 5125: Uint32Array, 5126: Float32Array };

/// The chunks of a GLB: {json, bytes}.
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

/// {low, extent, vertices, triangles, values, corners, picture, shape, rotation}: `picture` is a blob or null, `shape` a number that rooms of equal geometry share.
function roomOf(buffer) {
    const { json, at } = chunksOf(buffer);
    const accessor = index => {
        const { bufferView, componentType, count, type, byteOffset = 0 } = json.accessors[index];
        const width = { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4 }[type];
        return new array_types[componentType](buffer, at + (json.bufferViews[bufferView].byteOffset ?? 0) + byteOffset, count * width);
    };
    const { attributes, indices } = json.meshes[0].primitives[0];
    const places = accessor(attributes.POSITION), uvs = attributes.TEXCOORD_0 === undefined ? null : accessor(attributes.TEXCOORD_0);
    const vertices = places.length / 3, points = new Float32Array(places.length);
    const rotation = json.nodes.find(node => node.mesh === 0)?.rotation ?? [0, 0, 0, 1];
    const low = [Infinity, Infinity, Infinity], high = low.map(value => -value);
    for (let i = 0; i < places.length; i += 3)
        turned([places[i], places[i + 1], places[i + 2]], rotation).forEach((value, axis) => {
            points[i + axis] = value;
            low[axis] = Math.min(low[axis], value);
            high[axis] = Math.max(high[axis], value);
        });
    const extent = low.map((value, axis) => Math.max(high[axis] - value, 1e-9));
    const values = new Uint16Array(6 * vertices), corners = Uint32Array.from(accessor(indices));
    const step = share => Math.round(65535 * Math.max(0, Math.min(1, share)));
    let shape = vertices;
    for (let i = 0; i < vertices; ++i) {
        for (let axis = 0; axis < 3; ++axis)
            values[6 * i + axis] = step((points[3 * i + axis] - low[axis]) / extent[axis]);
        if (uvs) {
            values[6 * i + 4] = step(uvs[2 * i]);
            values[6 * i + 5] = step(1 - uvs[2 * i + 1]);
        }
        for (let part = 0; part < 6; ++part)
            shape = (Math.imul(shape, 31) + values[6 * i + part]) | 0;
    }
    const image = json.images?.[0];
    const bytes = image && json.bufferViews[image.bufferView];
    const picture = bytes ? new Blob([new Uint8Array(buffer, at + (bytes.byteOffset ?? 0), bytes.byteLength)], { type: image.mimeType }) : null;
    return { low, extent, vertices, triangles: corners.length / 3, values, corners, picture, shape, rotation };
}
