//! A type of messages in a file, with the plans to read it.
//!
//! There is a plan for each encoding and each set of fields that the user names, not for each topic.

use std::sync::Arc;

use super::bytes::Wire;
use super::choice::Role;
use super::plan::{self, Plan};
use super::schema;

/// Maximum number of kept plans of one type.
const MOST_PLANS: usize = 16;

/// A type.
#[derive(Debug)]
pub(super) struct Schema {
    pub(super) name: String,
    pub(super) encoding: String,
    text: String,
    /// True if one of its definitions has the name of a known type of frames.
    pub(super) known: bool,
    /// True if a check sum covers its definition.
    pub(super) checked: bool,
    /// Offset of the first definition that contradicts it.
    pub(super) contested: Option<u64>,
    /// Its plans, by the messages' encoding and the fields that the user names.
    plans: Vec<Planned>,
}

/// The plan for one encoding and set of fields.
#[derive(Debug)]
struct Planned {
    /// Their encoding.
    wire: String,
    /// The fields that the user names.
    asked: Vec<(Role, String)>,
    plan: Option<Arc<Plan>>,
}

impl Schema {
    pub(super) fn new(name: String, encoding: String, text: String, checked: bool) -> Self {
        let known = plan::is_known(&schema::plain(&name));
        Self { name, encoding, text, known, checked, contested: None, plans: Vec::new() }
    }

    /// Compares it with another definition of the same number. One without a text only has a name.
    pub(super) fn compare(&mut self, name: &str, encoding: &str, text: &str, at: u64) {
        let other = !self.text.is_empty() && self.text != text;
        if other || self.name != name || self.encoding != encoding {
            self.contested.get_or_insert(at);
            self.known |= plan::is_known(&schema::plain(name));
        }
    }

    /// Returns the plan to read its messages in this encoding and by these fields.
    pub(super) fn plan(&mut self, wire: &str, asked: &[(Role, &str)]) -> Option<Arc<Plan>> {
        let names =
            |one: &Planned| one.asked.iter().map(|(role, name)| (*role, name.as_str())).eq(asked.iter().copied());
        if let Some(known) = self.plans.iter().find(|one| one.wire == wire && names(one)) {
            return known.plan.clone();
        }
        let plan = self.made(wire, asked).map(Arc::new);
        if self.plans.len() < MOST_PLANS {
            let asked = asked.iter().map(|(role, name)| (*role, (*name).to_owned())).collect();
            self.plans.push(Planned { wire: wire.to_owned(), asked, plan: plan.clone() });
        }
        plan
    }

    fn made(&self, wire: &str, asked: &[(Role, &str)]) -> Option<Plan> {
        let (wire, text) = match (self.encoding.as_str(), wire) {
            ("ros2msg", "cdr") => (Wire::Cdr, Some(self.text.as_str())),
            // Another language: only types that are known by their names.
            ("ros2idl" | "", "cdr") => (Wire::Cdr, None),
            ("ros1msg", "ros1") => (Wire::Ros1, Some(self.text.as_str())),
            _ => return None,
        };
        Plan::new(&schema::plain(&self.name), text, wire, asked)
    }
}
