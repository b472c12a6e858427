// The textured mesh in WebGL: turned, walked through, or seen from outside.

function bytesOf(base64) {
    const text = atob(base64);
    const result = new Uint8Array(text.length);
    for (let i = 0; i < text.length; ++i)
        result[i] = text.charCodeAt(i);
    return result.buffer;
}

const vector = values => new THREE.Vector3().fromArray(values);

async function textureOf(uri, anisotropy) {
    const picture = new Image();
    picture.src = uri;
    await picture.decode();
    const texture = new THREE.Texture(picture);
    texture.anisotropy = anisotropy;
    texture.needsUpdate = true;
    return texture;
}

/// What texture.mix computes, for any shares: in the values of its pictures, as it does.
async function mixingMaterial(mixture, anisotropy) {
    const uniforms = { color: { value: mixture.color }, strokes: { value: mixture.strokes } };
    for (const name of ["photo", "colors", "painted"])
        uniforms[name] = { value: await textureOf(mixture[name], anisotropy) };
    return new THREE.ShaderMaterial({
        uniforms,
        vertexShader: "varying vec2 at; void main() { at = uv; gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0); }",
        fragmentShader: `
            uniform sampler2D photo, colors, painted; uniform float color, strokes; varying vec2 at;
            void main() {
                vec3 p = texture2D(photo, at).rgb, c = texture2D(colors, at).rgb, s = texture2D(painted, at).rgb;
                gl_FragColor = vec4(clamp(p + color * (c - p) + strokes * (s - c), 0.0, 1.0), 1.0);
            }`,
    });
}

/// Six numbers of 16 bits per vertex: x, y, z, 0, u, v; then three of 32 bits per face.
async function meshOf(room, mixture, anisotropy) {
    const packed = bytesOf(room.geometry);
    const values = new THREE.InterleavedBuffer(new Uint16Array(packed, 0, 6 * room.vertices), 6);
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.InterleavedBufferAttribute(values, 3, 0, true));
    geometry.setAttribute("uv", new THREE.InterleavedBufferAttribute(values, 2, 4, true));
    geometry.setIndex(new THREE.BufferAttribute(new Uint32Array(packed, 12 * room.vertices, 3 * room.triangles), 1));
    const material = mixture ? await mixingMaterial(mixture, anisotropy) : new THREE.MeshBasicMaterial({ map: await textureOf(room.texture, anisotropy) });
    const mesh = new THREE.Mesh(geometry, material);
    mesh.position.fromArray(room.low);
    mesh.scale.fromArray(room.extent.map(size => Math.max(size, 1e-9)));
    mesh.frustumCulled = false;  // Its bounds are unknown to three.js, which reads the packed numbers as they are.
    return { mesh, values: values.array };
}

/// What most of the vertices lie in: crumbs far off would make the room a spot in the middle.
function coreOf(room, values) {
    const step = Math.max(1, Math.floor(room.vertices / 20000));
    const ends = [0, 1, 2].map(axis => {
        const sample = [];
        for (let i = 0; i < room.vertices; i += step)
            sample.push(values[6 * i + axis] / 65535);
        sample.sort((a, b) => a - b);
        return [0.02, 0.98].map(share => room.low[axis] + room.extent[axis] * sample[Math.floor(share * (sample.length - 1))]);
    });
    const [low, high] = [0, 1].map(end => vector(ends.map(axis => axis[end])));
    return { middle: low.clone().add(high).multiplyScalar(0.5), reach: high.distanceTo(low) };
}

/// Fills the box; gives {inside, outside, standAt, mix}. `mixture`: what texture.mix shows, or nothing. `cameras`: where the recorder stood, {position, forward, up, looking}, or nothing;
/// `up`: what a stage found, or nothing.
async function showRoom(place, room, mixture, cameras, up) {
    if (!document.createElement("canvas").getContext("webgl"))
        throw new Error("this browser has no WebGL.");
    const renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    renderer.setClearColor(0x20242a);
    const { mesh, values } = await meshOf(room, mixture, renderer.capabilities.getMaxAnisotropy());
    const scene = new THREE.Scene();
    scene.add(mesh);
    const reach = vector(room.extent).length();
    const camera = new THREE.PerspectiveCamera(60, 1, reach / 2000, reach * 10);
    const upwards = vector(up ?? cameras?.up ?? [0, 0, 1]);
    camera.up.copy(upwards);
    const controls = new THREE.OrbitControls(camera, renderer.domElement);
    controls.screenSpacePanning = true;
    const draw = () => renderer.render(scene, camera);
    const look = (position, target) => {
        camera.position.copy(position);
        controls.target.copy(target);
        controls.update();
        draw();
    };
    const standAt = pose => look(vector(pose.position), vector(pose.forward).multiplyScalar(Math.min(1.5, reach / 4)).add(vector(pose.position)));
    const core = coreOf(room, values);
    // Backs of faces are not drawn: from above and outside one looks in, from behind where the cameras were.
    const outside = () => {
        const from = direction => vector(direction).addScaledVector(upwards, -vector(direction).dot(upwards));
        let side = from((cameras?.looking ?? [0, 0, 0]).map(part => -part));
        if (side.length() < 0.05)
            side = from([0.6, 0.35, 0.72]);
        side.normalize().addScaledVector(upwards, 0.9).normalize();
        look(core.middle.clone().addScaledVector(side, core.reach), core.middle);
    };
    const mix = (name, share) => {
        mesh.material.uniforms[name].value = share;
        draw();
    };
    const inside = () => cameras ? standAt(cameras) : outside();
    const resize = () => {
        const { width, height } = place.getBoundingClientRect();
        renderer.setSize(width, height, false);
        camera.aspect = width / Math.max(height, 1);
        camera.updateProjectionMatrix();
        draw();
    };
    controls.addEventListener("change", draw);
    window.addEventListener("resize", resize);
    place.prepend(renderer.domElement);
    renderer.domElement.tabIndex = 0;
    inside();
    resize();
    place.dataset.ready = "yes";
    return { inside, outside, standAt, mix };
}

/// Which way is up, as the last stage found that reported it; undefined where none did.
const upOf = stages => stages.map(stage => stage.figures.up).filter(Array.isArray).at(-1);

/// Sliders for the shares of a mixture, and the line that brings them into the pipeline. `mix`: draws the room with a share.
function mixtureBar(stage, mixture, mix) {
    const shares = { color: mixture.color, strokes: mixture.strokes };
    const line = element("code", { id: "shares" });
    const tell = () => line.textContent = `${stage}: {color: ${shares.color}, strokes: ${shares.strokes}}`;
    tell();
    const slider = name => element("label", {}, `${name} `, element("input", {
        type: "range", min: 0, max: 1, step: 0.01, value: shares[name], id: `mix-${name}`,
        oninput: event => {
            shares[name] = Number(event.target.value);
            mix(name, shares[name]);
            tell();
        },
    }));
    return element("div", { class: "bar" }, slider("color"), slider("strokes"), line);
}

/// The room's section, and what puts the visitor to a pose; nulls where there is no room.
function roomSection(data, media) {
    const entry = media.filter(each => each.room).at(-1);
    if (!entry)
        return { node: null, standAt: null };
    if (typeof THREE === "undefined")
        return { node: section("The room", element("p", { class: "note" }, "To turn the room around here, build fresco where three.js is (Debian's libjs-three).")), standAt: null };
    const frames = media.filter(each => each.cameras);
    const cameras = (frames.filter(each => each.pictures).at(-1) ?? frames.at(-1))?.cameras;
    const mixed = media.filter(each => each.mixture && each.mixture.atlas === entry.room.atlas).at(-1);
    const place = element("div", { id: "room" }, element("p", { class: "soft" }, "Drag: turn · right button: move · wheel: nearer and farther"));
    let shown = null;
    const start = () => showRoom(place, entry.room, mixed?.mixture, cameras, upOf(data.stages)).then(room => shown = room).catch(error =>
        place.replaceChildren(element("p", { class: "soft" }, `The room cannot be shown here: ${error.message}`)));
    const { triangles, extent } = entry.room;
    const node = section("The room", place, mixed && mixtureBar(mixed.stage, mixed.mixture, (name, share) => shown?.mix(name, share)), element("div", { class: "bar" },
        cameras && element("button", { id: "inside", onclick: () => shown?.inside() }, "Stand inside"),
        element("button", { id: "outside", onclick: () => shown?.outside() }, "Look from outside"),
        element("span", { class: "soft" }, `${figureText(triangles)} faces of ${entry.stage}, positions to ${figureText(Number((1000 * Math.max(...extent) / 65535).toPrecision(2)))} mm`)));
    const standAt = pose => {
        shown?.standAt(pose);
        place.scrollIntoView({ block: "center" });
    };
    return { node, standAt, start };
}
