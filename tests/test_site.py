"""The check of the built site finds what is wrong with it."""

from tests.site import faults


def write(folder, **pages):
    for name, body in pages.items():
        (folder / f"{name}.html").write_text(
            f"<html><head><title>{name}</title></head><body>{body}</body></html>"
        )


def test_a_site_in_order(tmp_path):
    write(
        tmp_path,
        index='<h1 id="top">1</h1><a href="#top">up</a><a href="other.html#here">there</a><img src="picture.png">'
        "<code>\\frac</code><math>x</math>",
        other='<p id="here"><a href="https://elsewhere.org/missing">out</a>costs $5</p>',
    )
    (tmp_path / "picture.png").write_bytes(b"picture")
    assert list(faults(tmp_path)) == []


def test_what_is_wrong_is_found(tmp_path):
    (tmp_path / "gallery").mkdir()
    write(
        tmp_path,
        index='<a href="nowhere.html">a</a><a href="other.html#gone">b</a><img src="missing.png">'
        '<script src="https://cdn.org/mathjax.js"></script><p>where \\frac{1}{2} is</p>',
        other="<p>x</p>",
    )
    write(tmp_path / "gallery", example="<p>no picture</p>")
    assert list(faults(tmp_path)) == [
        "gallery/example.html: there is no picture",
        "index.html: the link nowhere.html leads to no file",
        "index.html: the link other.html#gone leads to no such place on its page",
        "index.html: missing.png is not there",
        "index.html: https://cdn.org/mathjax.js needs a network",
        "index.html: \\frac stands in the text, a formula that was not converted",
    ]
