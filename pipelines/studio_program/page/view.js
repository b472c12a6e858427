// The room in the middle: its mesh, then the photo on it, then paintings, between which and the photo a slider fades.

/// The surface by its slope to the eye, where there are no colors yet.
const clay = () => new THREE.ShaderMaterial({
    extensions: { derivatives: true },
    vertexShader: over_surface,
    fragmentShader: `
        varying vec3 place;
        void main() {
            vec3 normal = normalize(cross(dFdx(place), dFdy(place))), eye = normalize(cameraPosition - place);
            gl_FragColor = vec4(vec3(0.62, 0.62, 0.60) * (0.35 + 0.65 * abs(dot(normal, eye))), 1.0);
        }`,
});

/// A texture where the texcoords say.
const flat = (texture, wireframe) => new THREE.ShaderMaterial({
    uniforms: { picture: { value: texture } }, wireframe, side: THREE.DoubleSide, depthTest: false,
    vertexShader: "varying vec2 at; void main() { at = uv; gl_Position = vec4(2.0 * uv - 1.0, 0.0, 1.0); }",
    fragmentShader: "uniform sampler2D picture; varying vec2 at; void main() { gl_FragColor = vec4(texture2D(picture, at).rgb, 1.0); }",
});

class View {
    constructor(place) {
        this.place = place;
        this.share = 1;
        this.clear();
    }

    clear() {
        this.viewer?.dispose();
        this.viewer = null;
        this.shape = null;
        this.has = "nothing";  // mesh, photo or painting
        this.photo = null;
        this.rotation = [0, 0, 0, 1];
    }

    /// What is in sight, as options of mesh.in_view.
    get sight() {
        const { position, forward } = this.viewer.pose(), camera = this.viewer.camera;
        const [x, y, z, w] = this.rotation, inMesh = vector => turned(vector, [-x, -y, -z, w]).map(value => Number(value.toFixed(4)));
        const up = new THREE.Vector3(0, 1, 0).applyQuaternion(camera.quaternion).toArray();
        return { position_m: inMesh(position), forward: inMesh(forward), up: inMesh(up), field_deg: camera.fov, aspect: Math.min(10, Math.max(0.1, camera.aspect)) };
    }

    get material() {
        return this.viewer.scene.children[0].material;
    }

    /// Shows a room's geometry; the place of the eye stays where a room was before.
    async build(room, pictures) {
        const before = this.viewer && { mode: this.place.dataset.mode, pose: this.viewer.pose(), extent: this.extent };
        const urls = pictures.map(picture => URL.createObjectURL(picture));
        const viewer = await showRoom(this.place, room, { mixture: { photo: urls[0], colors: urls.at(-1), painted: urls.at(-1), color: this.share, strokes: 0 }, up: [0, 1, 0] });
        urls.forEach(url => URL.revokeObjectURL(url));
        this.viewer?.dispose();
        this.viewer = viewer;
        this.shape = room.shape;
        this.rotation = room.rotation;
        const same = before && room.extent.every((size, axis) => Math.abs(size - before.extent[axis]) < 0.1 * size + 0.1);
        if (same && before.mode === "orbit")
            viewer.orbit();
        else if (same)
            viewer.standAt(before.pose);
        this.extent = room.extent;
        this.tell();
    }

    async mesh(buffer) {
        const room = roomOf(buffer);
        const gray = await new Promise(resolve => {
            const canvas = document.createElement("canvas");
            canvas.width = canvas.height = 1;
            canvas.getContext("2d").fillRect(0, 0, 1, 1);
            canvas.toBlob(resolve);
        });
        await this.build(room, [gray]);
        this.viewer.scene.children[0].material = clay();
        this.viewer.draw();
        this.has = "mesh";
        this.tell();
    }

    async photographed(buffer) {
        const room = roomOf(buffer);
        if (!room.picture)
            return this.mesh(buffer);
        this.photo = room.picture;
        await this.build(room, [room.picture]);
        this.has = "photo";
        this.tell();
    }

    /// `photo`: the same geometry with the photo; read only where the one in sight is another.
    async painted(buffer, photo) {
        const room = roomOf(buffer);
        if (room.shape !== this.shape || this.has === "mesh") {
            this.photo = roomOf(await photo()).picture;
            await this.build(room, [this.photo, room.picture]);
        } else
            await this.paint(room.picture);
        this.has = "painting";
        this.tell();
    }

    /// A painting of a part of the surface: drawn into the atlas, over the photo.
    async glimpsed(buffer, photo) {
        const part = roomOf(buffer), room = roomOf(await photo());
        if (room.shape !== this.shape || this.has === "mesh") {
            this.photo = room.picture;
            await this.build(room, [this.photo]);
        }
        const { renderer, camera } = this.viewer, anisotropy = renderer.capabilities.getMaxAnisotropy();
        const url = URL.createObjectURL(part.picture), painted = await textureOf(url, anisotropy);
        URL.revokeObjectURL(url);
        const shape = shapeOf(part), atlas = new THREE.Scene();
        const lay = (geometry, texture, wireframe) => {
            const mesh = new THREE.Mesh(geometry, flat(texture, wireframe));
            atlas.add(Object.assign(mesh, { frustumCulled: false, renderOrder: atlas.children.length }));
        };
        lay(new THREE.PlaneGeometry(2, 2), this.material.uniforms.photo.value, false);
        lay(shape, painted, true);  // A line around each face, for lookups at the borders of charts.
        lay(shape, painted, false);
        const side = painted.image.width, before = this.target;
        this.target = new THREE.WebGLRenderTarget(side, side, { generateMipmaps: true, minFilter: THREE.LinearMipmapLinearFilter, anisotropy, depthBuffer: false });
        renderer.setRenderTarget(this.target);
        renderer.render(atlas, camera);
        renderer.setRenderTarget(null);
        this.cover(this.target.texture);
        for (const unused of [before, painted, shape])
            unused?.dispose();
        this.has = "painting";
        this.tell();
    }

    /// Another picture of the atlas in sight.
    async paint(picture) {
        const url = URL.createObjectURL(picture);
        const texture = await textureOf(url, this.viewer.renderer.capabilities.getMaxAnisotropy());
        URL.revokeObjectURL(url);
        this.cover(texture);
    }

    cover(texture) {
        const { colors, painted } = this.material.uniforms;
        colors.value.dispose();
        colors.value = painted.value = texture;
        this.viewer.draw();
    }

    /// A painting on its way, on the room of `photo`.
    async growing(photo, picture) {
        const room = roomOf(photo);
        if (room.shape !== this.shape || this.has === "mesh") {
            this.photo = room.picture;
            await this.build(room, [room.picture, picture]);
        } else
            await this.paint(picture);
        this.has = "painting";
        this.tell();
    }

    mix(share) {
        this.share = share;
        if (this.has === "photo" || this.has === "painting")
            this.viewer.mix("color", share);
    }

    move(mode) {
        this.viewer?.[mode]();
        this.tell();
        this.place.querySelector("canvas")?.focus();
    }

    tell() {
        this.onchange?.();
    }

    /// A JPEG of the painting, from where one stands.
    async thumbnail() {
        this.viewer.mix("color", 1);
        const canvas = this.viewer.renderer.domElement, small = document.createElement("canvas");
        [small.width, small.height] = [280, 180];
        const scale = Math.max(280 / canvas.width, 180 / canvas.height);
        const [width, height] = [canvas.width * scale, canvas.height * scale];
        this.viewer.draw();
        small.getContext("2d").drawImage(canvas, (280 - width) / 2, (180 - height) / 2, width, height);
        this.mix(this.share);
        return new Promise(resolve => small.toBlob(resolve, "image/jpeg", 0.85));
    }
}
