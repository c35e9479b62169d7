//! The page: what `make web` built, embedded in the binary.

use axum::Router;
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, Uri, header};
use axum::response::{IntoResponse, Response};
use granary_api::id::ArtifactHash;

/// A file's path and bytes.
type File = (&'static str, &'static [u8]);

/// Every file; none if the page was not built.
const FILES: &[File] = include!(concat!(env!("OUT_DIR"), "/page_files.rs"));

/// What the page may do: run its own files and speak to this server.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; font-src 'self'; \
    connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

const NOT_BUILT: &str = "This granary was built without its page: run `make web` and build it again; the API is at /api/v1.\n";

/// Answers every path that is not the API's.
pub(crate) fn router() -> Router {
    Router::new().fallback(|method: Method, uri: Uri, headers: HeaderMap| async move {
        answer(FILES, &method, uri.path(), &headers)
    })
}

/// The file at `path`, its gzipped twin if the reader takes it, or why there is none.
fn answer(files: &[File], method: &Method, path: &str, asked: &HeaderMap) -> Response {
    if !matches!(*method, Method::GET | Method::HEAD) {
        return (
            StatusCode::METHOD_NOT_ALLOWED,
            [(header::ALLOW, "GET, HEAD")],
        )
            .into_response();
    }
    let find = |name: &str| {
        files
            .iter()
            .find(|(known, _)| *known == name)
            .map(|(_, bytes)| *bytes)
    };
    let name = if path == "/" {
        "index.html"
    } else {
        path.trim_start_matches('/')
    };
    let Some(plain) = find(name) else {
        let reason = if files.is_empty() {
            NOT_BUILT.to_owned()
        } else {
            format!("There is no page {path}.\n")
        };
        return (StatusCode::NOT_FOUND, reason).into_response();
    };
    let packed = find(&format!("{name}.gz")).filter(|_| takes_gzip(asked));
    let bytes = packed.unwrap_or(plain);
    let tag = format!("\"{}\"", ArtifactHash::of_bytes(bytes));
    let mut response = if has(asked, &tag) {
        StatusCode::NOT_MODIFIED.into_response()
    } else {
        bytes.into_response()
    };
    let headers = response.headers_mut();
    for (name, value) in describe(name) {
        headers.insert(name, HeaderValue::from_static(value));
    }
    if packed.is_some() {
        headers.insert(header::CONTENT_ENCODING, HeaderValue::from_static("gzip"));
    }
    if let Ok(tag) = HeaderValue::from_str(&tag) {
        headers.insert(header::ETAG, tag);
    }
    response
}

/// The headers that the name decides: what lies in `assets` has the hash of its content in its name.
fn describe(name: &str) -> [(HeaderName, &'static str); 6] {
    let kind = match name.rsplit_once('.').map_or("", |(_, extension)| extension) {
        "html" => "text/html; charset=utf-8",
        "js" => "text/javascript; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "svg" => "image/svg+xml",
        "woff2" => "font/woff2",
        _ => "application/octet-stream",
    };
    let keep = if name.starts_with("assets/") {
        "public, max-age=31536000, immutable"
    } else {
        "no-cache"
    };
    [
        (header::CONTENT_TYPE, kind),
        (header::CACHE_CONTROL, keep),
        (header::VARY, "accept-encoding"),
        (header::CONTENT_SECURITY_POLICY, POLICY),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
    ]
}

fn takes_gzip(asked: &HeaderMap) -> bool {
    let encodings = asked
        .get(header::ACCEPT_ENCODING)
        .and_then(|value| value.to_str().ok());
    encodings.is_some_and(|value| {
        value.split(',').any(|one| {
            one.split(';')
                .next()
                .is_some_and(|name| name.trim() == "gzip")
        })
    })
}

/// Whether the reader has the file of this tag already.
fn has(asked: &HeaderMap, tag: &str) -> bool {
    let known = asked
        .get(header::IF_NONE_MATCH)
        .and_then(|value| value.to_str().ok());
    known.is_some_and(|known| known.contains(tag))
}

#[cfg(test)]
mod tests {
    use super::*;

    const BUILT: &[File] = &[
        ("assets/index-1.js", b"plain"),
        ("assets/index-1.js.gz", b"packed"),
        ("index.html", b"<!doctype html>"),
    ];

    fn get(files: &[File], path: &str, asked: &[(HeaderName, &str)]) -> Response {
        let value = |text: &str| HeaderValue::from_str(text).expect("a value");
        let asked = asked
            .iter()
            .map(|(name, text)| (name.clone(), value(text)))
            .collect();
        answer(files, &Method::GET, path, &asked)
    }

    #[test]
    fn page_that_was_not_built_says_how_to_build_it() {
        assert_eq!(get(&[], "/", &[]).status(), StatusCode::NOT_FOUND);
        assert!(NOT_BUILT.contains("make web"));
    }

    #[test]
    fn hashed_assets_are_kept_for_good_and_the_page_itself_is_asked_for_again() {
        let page = get(BUILT, "/", &[]);
        assert_eq!(page.headers()[header::CACHE_CONTROL], "no-cache");
        assert_eq!(page.headers()[header::CONTENT_SECURITY_POLICY], POLICY);
        let script = get(BUILT, "/assets/index-1.js", &[]);
        assert_eq!(
            script.headers()[header::CONTENT_TYPE],
            "text/javascript; charset=utf-8"
        );
        assert!(
            script.headers()[header::CACHE_CONTROL]
                .to_str()
                .is_ok_and(|keep| keep.contains("immutable"))
        );
    }

    #[test]
    fn known_file_is_not_sent_again_and_a_packed_one_has_a_tag_of_its_own() {
        let gzip = (header::ACCEPT_ENCODING, "br, gzip;q=0.5");
        let packed = get(BUILT, "/assets/index-1.js", std::slice::from_ref(&gzip));
        assert_eq!(packed.headers()[header::CONTENT_ENCODING], "gzip");
        let tag = packed.headers()[header::ETAG]
            .to_str()
            .expect("a tag")
            .to_owned();
        let again = get(
            BUILT,
            "/assets/index-1.js",
            &[gzip, (header::IF_NONE_MATCH, &tag)],
        );
        assert_eq!(again.status(), StatusCode::NOT_MODIFIED);
        let plain = get(
            BUILT,
            "/assets/index-1.js",
            &[(header::IF_NONE_MATCH, &tag)],
        );
        assert_eq!(plain.status(), StatusCode::OK);
    }

    #[test]
    fn unknown_path_and_a_write_are_refused() {
        assert_eq!(
            get(BUILT, "/../Cargo.toml", &[]).status(),
            StatusCode::NOT_FOUND
        );
        let written = answer(BUILT, &Method::POST, "/", &HeaderMap::new());
        assert_eq!(written.status(), StatusCode::METHOD_NOT_ALLOWED);
    }
}
