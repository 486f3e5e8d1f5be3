//! The device descriptions that the page was given, for the sessions that follow.

use std::collections::BTreeMap;
use std::sync::Arc;

use canalyze_core::description::{self, DefectFact, DeviceDescription, Unusable};
use canalyze_core::world::dictionary::Dictionary;
use serde::Deserialize;
use serde_json::{Value, json};

/// A device description.
struct Filed {
    content: Vec<u8>,
    table: Arc<Dictionary>,
}

/// The descriptions, by their numbers.
#[derive(Default)]
pub struct Descriptions(Vec<Filed>);

/// A DCF to be made.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GivenDcf {
    /// The number of the description.
    number: usize,
    node: u8,
    /// Index, sub-index and data of each object.
    values: Vec<(u16, u8, Vec<u8>)>,
    /// Keys of FileInfo.
    keys: Vec<(String, String)>,
}

impl Descriptions {
    /// Returns the tables, in the order of their numbers.
    pub fn tables(&self) -> impl Iterator<Item = Arc<Dictionary>> {
        self.0.iter().map(|filed| Arc::clone(&filed.table))
    }

    /// Adds a description. Returns `form`, `node` of a DCF, `product`, the numbers of `objects` and `pdos`, and the
    /// number of its `defects` by their codes; or `error`: the key of a sentence and the facts in it.
    pub fn add(&mut self, content: &[u8], file: String) -> Value {
        let read = match description::read(content, file) {
            Ok(read) => read,
            Err(unusable) => return refused(unusable),
        };
        self.0.push(Filed { content: content.to_vec(), table: Arc::clone(&read.table) });
        json!({
            "form": read.form.name(), "node": read.node, "product": read.device.product_name,
            "objects": read.objects.len(), "pdos": read.pdos.len(), "defects": defects(&read),
        })
    }

    /// Returns the `text` of a DCF and the objects that are `left_out`; or `error` as [`Descriptions::add`].
    pub fn configured(&self, json: &[u8]) -> Value {
        let given: GivenDcf = match serde_json::from_slice(json) {
            Ok(given) => given,
            Err(error) => return json!({"error": [error.to_string(), {}]}),
        };
        let content = self.0.get(given.number).map_or(&[][..], |filed| &filed.content);
        let values = given.values.into_iter().map(|(index, sub, data)| ((index, sub), data)).collect();
        match description::configured(content, &values, given.node, &given.keys) {
            Ok(made) => json!({"text": made.text, "left_out": made.left_out}),
            Err(unusable) => refused(unusable),
        }
    }
}

fn refused(unusable: Unusable) -> Value {
    let (key, facts) = unusable.sentence();
    let facts: BTreeMap<_, _> = facts.iter().map(|(name, fact)| (*name, text(fact))).collect();
    json!({"error": [key, facts]})
}

/// Returns the number of defects by their codes, with those that the reader has only counted.
fn defects(read: &DeviceDescription) -> BTreeMap<String, u64> {
    let mut counts = BTreeMap::new();
    for defect in &read.defects {
        let fact = |wanted| defect.facts.iter().find(|(name, _)| *name == wanted).map(|(_, fact)| text(fact));
        let more = if defect.code == "more" { fact("code").zip(fact("count")) } else { None };
        let (code, count) = more.unwrap_or_else(|| (defect.code.to_owned(), "1".to_owned()));
        *counts.entry(code).or_default() += count.parse().unwrap_or(1);
    }
    counts
}

fn text(fact: &DefectFact) -> String {
    match fact {
        DefectFact::Whole(value) => value.to_string(),
        DefectFact::Real(value) => value.to_string(),
        DefectFact::Text(text) => text.clone(),
    }
}
