//! `/sweeps/{id}/events`: what happens to a sweep, as it happens.
//!
//! Stored events carry an id; `Last-Event-ID` resumes after it, and `reset` says that some were forgotten meanwhile.
//! `progress` is never stored: it is the summary as it stands, at most once a second.

use std::collections::VecDeque;
use std::convert::Infallible;
use std::time::Duration;

use axum::extract::State;
use axum::http::HeaderMap;
use axum::response::Sse;
use axum::response::sse::{Event as Sent, KeepAlive};
use futures_util::{Stream, stream};
use granary_api::id::SweepId;
use granary_api::problem::Problem;
use granary_api::sweep::Event;
use tokio::sync::watch;
use tokio::time::{Instant, timeout_at};

use super::App;
use super::body::Id;
use crate::error::ApiError;
use crate::store::StoreError;

/// Events read at a time.
const MOST: u32 = 500;
/// The least time between two `progress`.
const PAUSE: Duration = Duration::from_secs(1);

/// A reader of one sweep's events.
struct Follower {
    app: App,
    sweep: SweepId,
    row: i64,
    after: u64,
    waiting: VecDeque<Sent>,
    changes: watch::Receiver<u64>,
    next_progress: Instant,
    /// Whether something has changed since the last `progress`.
    stale: bool,
}

/// The events of a sweep from the first, or after `Last-Event-ID`, without end.
#[utoipa::path(get, path = "/api/v1/sweeps/{sweep}/events",
    params(("sweep" = SweepId, Path), ("Last-Event-ID" = Option<u64>, Header)),
    responses((status = 200, body = Event, content_type = "text/event-stream"), (status = 404, body = Problem)))]
pub(super) async fn follow_sweep(
    State(app): State<App>,
    Id(sweep): Id<SweepId>,
    headers: HeaderMap,
) -> Result<Sse<impl Stream<Item = Result<Sent, Infallible>>>, ApiError> {
    let row = app.store.sweep_plan(sweep).await?.id;
    let (first, last) = app.store.event_range(row).await?;
    let asked = headers.get("last-event-id").and_then(|id| id.to_str().ok());
    let asked = asked.and_then(|id| id.parse::<u64>().ok());
    let mut waiting = VecDeque::new();
    let after = match asked {
        Some(id) if id + 1 < first || id > last => {
            waiting.push_back(Sent::default().event("reset").data("{}"));
            first.saturating_sub(1)
        }
        Some(id) => id,
        None => 0,
    };
    let follower = Follower {
        changes: app.store.subscribe(),
        app,
        sweep,
        row,
        after,
        waiting,
        next_progress: Instant::now(),
        stale: true,
    };
    let events = stream::unfold(follower, |mut follower| async move {
        let event = follower.next().await?;
        Some((Ok(event), follower))
    });
    Ok(Sse::new(events).keep_alive(KeepAlive::new().interval(Duration::from_secs(15))))
}

impl Follower {
    /// The next event; none when the server stops or fails.
    async fn next(&mut self) -> Option<Sent> {
        loop {
            if let Some(event) = self.waiting.pop_front() {
                return Some(event);
            }
            self.changes.borrow_and_update();
            if let Err(error) = self.read().await {
                tracing::error!(%error, "events cannot be read");
                return None;
            }
            if self.waiting.is_empty() && !self.wait().await {
                return None;
            }
        }
    }

    /// Reads what was stored since, and the summary if it is due.
    async fn read(&mut self) -> Result<(), StoreError> {
        for event in self
            .app
            .store
            .event_list(self.row, self.after, MOST)
            .await?
        {
            self.after = event.id;
            let sent = Sent::default().id(event.id.to_string()).event(&event.kind);
            self.waiting
                .push_back(sent.data(serde_json::to_string(&event).unwrap_or_default()));
        }
        if self.stale && Instant::now() >= self.next_progress {
            let mut summary = self.app.store.sweep_read(self.sweep).await?;
            summary.spec = None;
            let sent = Sent::default().event("progress");
            self.waiting
                .push_back(sent.data(serde_json::to_string(&summary).unwrap_or_default()));
            self.next_progress = Instant::now() + PAUSE;
            self.stale = false;
        }
        Ok(())
    }

    /// Waits for a change, or until a `progress` is due; false when the server stops.
    async fn wait(&mut self) -> bool {
        let due = if self.stale {
            self.next_progress
        } else {
            Instant::now() + Duration::from_hours(1)
        };
        tokio::select! {
            () = self.app.shutdown.cancelled() => false,
            changed = timeout_at(due, self.changes.changed()) => {
                self.stale |= matches!(changed, Ok(Ok(())));
                !matches!(changed, Ok(Err(_)))
            }
        }
    }
}
