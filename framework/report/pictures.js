// What there is to look at: the pictures that no part of a viewer shows.

const fileOf = (entry, picture) => entry.folder ? `${entry.folder}/${picture.name}` : picture.name;

const pictureOf = (uri, name) => uri.startsWith("data:video/") ? element("video", { controls: true, loop: true, src: uri, title: name }) : element("img", { src: uri, alt: name });

const captioned = (picture, name, caption) => element("figure", {}, pictureOf(picture.uri, name), element("figcaption", {}, caption));

/// Pictures that no file holds: [{entry, picture, ports}], with the ports of the stages that read them.
const ownPictures = (data, media) => media.filter(entry => entry.folder === undefined).flatMap(entry => {
    const readers = data.stages.flatMap(stage => stage.inputs).filter(input => input.stage === entry.stage && input.output === entry.port).map(input => input.port);
    return (entry.pictures ?? []).map(picture => ({ entry, picture, ports: entry.file ? [entry.port] : [...new Set(readers)] }));
});

/// What stages painted after: "style: waves.jpg".
const inputPictures = (data, media) => ownPictures(data, media).filter(({ picture, ports }) => ports.length && !picture.section).map(({ entry, picture, ports }) =>
    captioned(picture, entry.stage, `${ports.join(", ")}: ${entry.file ? entry.file.split("/").at(-1) : entry.stage}`));

/// A section for each title that pictures ask for: "The atlas".
function titledPictures(data, media) {
    const titled = ownPictures(data, media).filter(({ picture }) => picture.section);
    return [...new Set(titled.map(({ picture }) => picture.section))].map(title => section(title, element("div", { class: "titled" },
        titled.filter(({ picture }) => picture.section === title).map(({ entry, picture }) => captioned(picture, title, `${entry.stage}, ${picture.name}`)))));
}

function otherPictures(data, media) {
    const files = media.filter(entry => entry.folder !== undefined).flatMap(entry => (entry.pictures ?? []).map(picture => {
        const file = fileOf(entry, picture);
        return captioned(picture, file, link(file, file));
    }));
    const unread = ownPictures(data, media).filter(({ picture, ports }) => !ports.length && !picture.section)
        .map(({ entry, picture }) => captioned(picture, entry.stage, `${entry.stage}.${entry.port}`));
    return files.length + unread.length ? section("Other pictures", element("div", { class: "pictures" }, unread, files)) : null;
}
