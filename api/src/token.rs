//! Tokens: what their bearer may do.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// One thing that a token allows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Scope {
    /// Read everything.
    Read,
    /// Submit and steer sweeps; includes `read`.
    Submit,
    /// Lease jobs and store artifacts; includes `read`.
    Worker,
    /// Everything.
    Admin,
}

impl Scope {
    /// Whether a token with this scope may do what needs `needed`.
    #[must_use]
    pub fn allows(self, needed: Self) -> bool {
        self == Self::Admin || self == needed || needed == Self::Read
    }
}
