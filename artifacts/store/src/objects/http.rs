//! The HTTP client of the stores: ureq, which blocks. What asks runs on a runtime of its own thread, so nothing else waits.

use std::io;
use std::time::Duration;

use async_trait::async_trait;
use object_store::client::{
    HttpClient, HttpConnector, HttpError, HttpErrorKind, HttpRequest, HttpResponse,
    HttpResponseBody, HttpService,
};
use object_store::{ClientConfigKey, ClientOptions};
use ureq::Agent;
use ureq::tls::{PemItem, RootCerts, TlsConfig, parse_pem};

/// A server that says nothing for so long is asked again.
const SILENCE: Duration = Duration::from_secs(30);
/// Seconds to connect where the store's options say nothing else: the addresses of a cloud's machine are asked for one.
const CONNECT: u64 = 5;
/// Longest answer that is held; what is read is asked for in smaller pieces.
const LONGEST: u64 = 64 << 20;

/// Makes clients.
#[derive(Debug)]
pub struct Connector;

#[derive(Debug)]
struct Client {
    agent: Agent,
    /// Whether requests may go out without TLS: `AWS_ALLOW_HTTP` and the like.
    allows_http: bool,
}

impl HttpConnector for Connector {
    fn connect(&self, options: &ClientOptions) -> object_store::Result<HttpClient> {
        let allows = options.get_config_value(&ClientConfigKey::AllowHttp);
        let connect = options.get_config_value(&ClientConfigKey::ConnectTimeout);
        let connect = connect.and_then(|text| text.strip_suffix('s')?.parse().ok());
        let config = Agent::config_builder()
            .http_status_as_error(false)
            .max_redirects(0)
            .max_redirects_will_error(false)
            .accept_encoding("identity")
            .user_agent(concat!("carom/", env!("CARGO_PKG_VERSION")))
            .tls_config(TlsConfig::builder().root_certs(roots()).build())
            .timeout_connect(Some(Duration::from_secs(connect.unwrap_or(CONNECT))))
            .timeout_per_read(Some(SILENCE))
            .timeout_recv_response(Some(SILENCE))
            .timeout_per_write(Some(SILENCE));
        Ok(HttpClient::new(Client {
            agent: config.build().new_agent(),
            allows_http: allows.is_some_and(|value| value == "true"),
        }))
    }
}

/// Mozilla's, and in their place those of the file that `SSL_CERT_FILE` names: a laboratory's own store has its own.
fn roots() -> RootCerts {
    let file = std::env::var_os("SSL_CERT_FILE").and_then(|path| std::fs::read(path).ok());
    let Some(text) = file else {
        return RootCerts::WebPki;
    };
    let items = parse_pem(&text).filter_map(|item| match item {
        Ok(PemItem::Certificate(certificate)) => Some(certificate),
        _ => None,
    });
    let certificates: Vec<_> = items.collect();
    RootCerts::new_with_certs(&certificates)
}

#[async_trait]
impl HttpService for Client {
    async fn call(&self, request: HttpRequest) -> Result<HttpResponse, HttpError> {
        if request.uri().scheme_str() != Some("https") && !self.allows_http {
            let why = "the store's address has no TLS; set AWS_ALLOW_HTTP=true (GOOGLE_…, AZURE_…) if that is meant";
            return Err(HttpError::new(
                HttpErrorKind::Unknown,
                io::Error::other(why),
            ));
        }
        let (parts, body) = request.into_parts();
        let body = HttpResponseBody::new(body).bytes().await?;
        let request = ureq::http::Request::from_parts(parts, &body[..]);
        let answer = self.agent.run(request).map_err(failed)?;
        let (parts, mut body) = answer.into_parts();
        let bytes = body.with_config().limit(LONGEST).read_to_vec();
        Ok(HttpResponse::from_parts(
            parts,
            bytes.map_err(failed)?.into(),
        ))
    }
}

/// What may be asked again: a connection that never was, whatever the request; one that broke, where twice does no harm.
fn failed(error: ureq::Error) -> HttpError {
    use ureq::Error as E;
    let kind = match &error {
        E::HostNotFound
        | E::ConnectionFailed
        | E::Timeout(ureq::Timeout::Connect | ureq::Timeout::Resolve) => HttpErrorKind::Connect,
        E::Io(source) if source.kind() == io::ErrorKind::ConnectionRefused => {
            HttpErrorKind::Connect
        }
        E::Timeout(_) => HttpErrorKind::Timeout,
        E::Io(_) | E::Protocol(_) => HttpErrorKind::Interrupted,
        _ => HttpErrorKind::Unknown,
    };
    HttpError::new(kind, error)
}
