//! The one word to stop, passed down to everything that runs.

use tokio::sync::watch;

/// Hears the word to stop.
#[derive(Clone, Debug)]
pub struct Shutdown(watch::Receiver<bool>);

/// Gives the word to stop; dropping it gives the word too.
#[derive(Debug)]
pub struct ShutdownHandle(watch::Sender<bool>);

/// A word to stop that has not been given, and the handle that gives it.
#[must_use]
pub fn channel() -> (ShutdownHandle, Shutdown) {
    let (sender, receiver) = watch::channel(false);
    (ShutdownHandle(sender), Shutdown(receiver))
}

impl ShutdownHandle {
    /// Tells all who listen to stop.
    pub fn request(&self) {
        self.0.send_replace(true);
    }
}

impl Shutdown {
    /// Whether the word has been given.
    #[must_use]
    pub fn requested(&self) -> bool {
        *self.0.borrow() || self.0.has_changed().is_err()
    }

    /// Returns once the word has been given.
    pub async fn wait(&self) {
        // An error means that the handle is gone, and with it whoever could want more work.
        let _ = self.0.clone().wait_for(|stop| *stop).await;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn every_listener_hears_a_word_given_before_it_listened() {
        let (handle, shutdown) = channel();
        assert!(!shutdown.requested());
        handle.request();
        shutdown.clone().wait().await;
        shutdown.wait().await;
        assert!(shutdown.requested());
    }

    #[tokio::test]
    async fn a_dropped_handle_is_a_word_to_stop() {
        let (handle, shutdown) = channel();
        drop(handle);
        shutdown.wait().await;
        assert!(shutdown.requested());
    }
}
