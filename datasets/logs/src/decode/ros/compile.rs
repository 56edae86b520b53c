//! From a message definition and field paths to a plan.

use values::FieldTopic;

use super::super::ros_schema::{self, Base, Definition, Member, Primitive, Shape};
use super::{Element, Plan, Step, Wire};
use crate::path::{FieldTree, Leaf, first_name};
use crate::{LogError, SchemaText};

/// Types may nest this deep; ROS's own nest less than ten.
const DEEPEST: usize = 32;

impl Plan {
    /// The plan for messages of this schema, and whether they have a stamp.
    pub(in super::super) fn compile(
        wire: Wire,
        schema: SchemaText<'_>,
        topic: &FieldTopic,
        further: &[(Leaf, &str)],
    ) -> Result<(Self, bool), LogError> {
        let unusable = |why: String| LogError::Schema {
            topic: topic.name.clone(),
            schema: schema.name.into(),
            why,
        };
        let text = std::str::from_utf8(schema.data)
            .map_err(|_| unusable("it is not UTF-8 text".into()))?;
        if text.trim().is_empty() {
            let why = "it is empty: rosbag2 leaves a definition out that it does not find; record or convert where the message's package is installed";
            return Err(unusable(why.into()));
        }
        let definitions = ros_schema::parse(schema.name, text).map_err(unusable)?;
        let first = first_name(&topic.stamp);
        let stamped = definitions[0]
            .members
            .iter()
            .any(|member| member.name == first);
        let want = FieldTree::of(topic, further, stamped)?;
        let plan =
            Compiler::new(&definitions)
                .plan(wire, &want)
                .map_err(|failure| match failure {
                    Failure::Schema(why) => unusable(why),
                    Failure::Field(leaf, why) => leaf.astray(topic, why),
                })?;
        Ok((plan, stamped))
    }
}

enum Failure {
    Schema(String),
    Field(Leaf, String),
}

/// How far a type's pass is compiled.
#[derive(Clone)]
enum Pass {
    Unseen,
    Begun,
    /// The steps, and how deep types nest below.
    Done(Vec<Step>, usize),
}

struct Compiler<'a> {
    definitions: &'a [Definition],
    /// Definitions that the text leaves out because everyone knows them.
    built_in: Vec<Definition>,
    passes: Vec<Pass>,
}

impl<'a> Compiler<'a> {
    fn new(definitions: &'a [Definition]) -> Self {
        let names = [
            "time",
            "duration",
            "builtin_interfaces/Time",
            "builtin_interfaces/Duration",
        ];
        let built_in: Vec<_> = names
            .into_iter()
            .filter_map(|name| {
                Some(Definition {
                    name: name.into(),
                    members: ros_schema::built_in(name)?,
                })
            })
            .collect();
        let passes = vec![Pass::Unseen; definitions.len() + built_in.len()];
        Self {
            definitions,
            built_in,
            passes,
        }
    }

    fn plan(mut self, wire: Wire, want: &FieldTree) -> Result<Plan, Failure> {
        let mut steps = Vec::new();
        self.enter(0, want, 0, &mut steps)?;
        // Nothing after the last wanted field needs to be passed over.
        while matches!(steps.last(), Some(step) if !matches!(step, Step::Take(..) | Step::TakeText | Step::Elements { .. }))
        {
            steps.pop();
        }
        self.compile_passes(&steps, 0)?;
        let done = |pass| {
            if let Pass::Done(steps, _) = pass {
                steps
            } else {
                Vec::new()
            }
        };
        Ok(Plan {
            wire,
            steps,
            passes: self.passes.into_iter().map(done).collect(),
        })
    }

    /// Compiles the passes of all types that these steps pass over; how deep types nest in them.
    fn compile_passes(&mut self, steps: &[Step], depth: usize) -> Result<usize, Failure> {
        let mut types = Vec::new();
        types_in(steps, &mut types);
        let mut deepest = 0;
        for index in types {
            deepest = deepest.max(1 + self.compile_pass(index, depth + 1)?);
        }
        Ok(deepest)
    }

    fn compile_pass(&mut self, index: usize, depth: usize) -> Result<usize, Failure> {
        let below = match &self.passes[index] {
            Pass::Done(_, below) => *below,
            Pass::Begun => {
                return Err(Failure::Schema(format!(
                    "{} holds itself",
                    self.definition(index).name
                )));
            }
            Pass::Unseen if depth > DEEPEST => 0,
            Pass::Unseen => {
                self.passes[index] = Pass::Begun;
                let steps = self.pass(index)?;
                let below = self.compile_passes(&steps, depth)?;
                self.passes[index] = Pass::Done(steps, below);
                below
            }
        };
        if depth + below > DEEPEST {
            return Err(Failure::Schema(format!("types nest deeper than {DEEPEST}")));
        }
        Ok(below)
    }

    fn definition(&self, index: usize) -> &Definition {
        match index.checked_sub(self.definitions.len()) {
            None => &self.definitions[index],
            Some(built_in) => &self.built_in[built_in],
        }
    }

    /// Steps through a value of this type, taking what is wanted.
    fn enter(
        &self,
        index: usize,
        want: &FieldTree,
        depth: usize,
        steps: &mut Vec<Step>,
    ) -> Result<(), Failure> {
        if depth > DEEPEST {
            return Err(Failure::Schema(format!("types nest deeper than {DEEPEST}")));
        }
        let definition = self.definition(index);
        let members = definition.members.iter().map(|member| member.name.clone());
        let stamped = want.of_stamp(members);
        if let (Some(leaf), None) = (want.leaves.first(), &stamped) {
            return Err(Failure::Field(
                *leaf,
                format!("it is a {}, not a number", definition.name),
            ));
        }
        let want = stamped.as_ref().unwrap_or(want);
        for (name, below) in &want.fields {
            if !definition.members.iter().any(|member| member.name == *name) {
                let members: Vec<_> = definition
                    .members
                    .iter()
                    .map(|member| member.name.as_str())
                    .collect();
                let why = format!(
                    "{} has no `{name}` but {}",
                    definition.name,
                    members.join(", ")
                );
                return Err(Failure::Field(below.any_leaf(), why));
            }
        }
        if let Some((_, below)) = want.elements.first() {
            return Err(Failure::Field(
                below.any_leaf(),
                format!("{} is not an array", definition.name),
            ));
        }
        for member in &definition.members {
            match want.fields.iter().find(|(name, _)| *name == member.name) {
                Some((_, want)) => self.take(definition, member, want, depth, steps)?,
                None => steps.push(self.pass_member(definition, member)?),
            }
        }
        Ok(())
    }

    fn take(
        &self,
        user: &Definition,
        member: &Member,
        want: &FieldTree,
        depth: usize,
        steps: &mut Vec<Step>,
    ) -> Result<(), Failure> {
        let count = match member.shape {
            Shape::One => return self.take_value(user, &member.base, want, depth, steps),
            Shape::Array(count) => Some(count),
            Shape::Sequence => None,
        };
        if want.elements.is_empty() || !want.fields.is_empty() || !want.leaves.is_empty() {
            let why = format!(
                "`{0}` is an array; write `{0}[0]` for its first element",
                member.name
            );
            return Err(Failure::Field(want.any_leaf(), why));
        }
        let mut wanted = Vec::new();
        for (index, want) in &want.elements {
            if let Some(count) = count.filter(|count| index >= count) {
                return Err(Failure::Field(
                    want.any_leaf(),
                    format!("`{}` has {count} elements", member.name),
                ));
            }
            let mut inner = Vec::new();
            self.take_value(user, &member.base, want, depth, &mut inner)?;
            wanted.push((*index, inner));
        }
        wanted.sort_by_key(|(index, _)| *index);
        steps.push(Step::Elements {
            count,
            wanted,
            element: self.element(user, &member.base)?,
        });
        Ok(())
    }

    fn take_value(
        &self,
        user: &Definition,
        base: &Base,
        want: &FieldTree,
        depth: usize,
        steps: &mut Vec<Step>,
    ) -> Result<(), Failure> {
        match base {
            Base::Number(primitive) if want.fields.is_empty() && want.elements.is_empty() => {
                steps.push(Step::Take(*primitive, want.leaves.clone()));
                Ok(())
            }
            Base::Number(_) => Err(Failure::Field(
                want.any_leaf(),
                "the path goes on below a number".into(),
            )),
            Base::Text if want.is_text() => {
                steps.push(Step::TakeText);
                Ok(())
            }
            Base::Text | Base::WideText => Err(Failure::Field(
                want.any_leaf(),
                "there is text, no number".into(),
            )),
            Base::Named(name) => self.enter(self.resolve(user, name)?, want, depth + 1, steps),
        }
    }

    /// Steps over a value of this type. A type without members takes one byte (rosidl's dummy member).
    fn pass(&self, index: usize) -> Result<Vec<Step>, Failure> {
        let definition = self.definition(index);
        if definition.members.is_empty() {
            return Ok(vec![Step::Pass(Primitive::U8, 1)]);
        }
        definition
            .members
            .iter()
            .map(|member| self.pass_member(definition, member))
            .collect()
    }

    fn pass_member(&self, user: &Definition, member: &Member) -> Result<Step, Failure> {
        let element = self.element(user, &member.base)?;
        Ok(match member.shape {
            Shape::One => element.pass(1),
            Shape::Array(count) => element.pass(count),
            Shape::Sequence => Step::PassSequence(element),
        })
    }

    fn element(&self, user: &Definition, base: &Base) -> Result<Element, Failure> {
        match base {
            Base::Number(primitive) => Ok(Element::Number(*primitive)),
            Base::Text => Ok(Element::Text),
            Base::WideText => Ok(Element::WideText),
            Base::Named(name) => Ok(Element::Type(self.resolve(user, name)?)),
        }
    }

    fn resolve(&self, user: &Definition, name: &str) -> Result<usize, Failure> {
        ros_schema::resolve(self.definitions, &user.name, name)
            .or_else(|| {
                let at = self
                    .built_in
                    .iter()
                    .position(|definition| definition.name == name)?;
                Some(self.definitions.len() + at)
            })
            .ok_or_else(|| {
                Failure::Schema(format!("{} uses {name}, which is not defined", user.name))
            })
    }
}

/// Types that steps pass over.
fn types_in(steps: &[Step], types: &mut Vec<usize>) {
    for step in steps {
        match step {
            Step::PassType(index, _) | Step::PassSequence(Element::Type(index)) => {
                types.push(*index)
            }
            Step::Elements {
                wanted, element, ..
            } => {
                if let Element::Type(index) = element {
                    types.push(*index);
                }
                for (_, steps) in wanted {
                    types_in(steps, types);
                }
            }
            Step::Take(..)
            | Step::TakeText
            | Step::Pass(..)
            | Step::PassText(_)
            | Step::PassWideText(_)
            | Step::PassSequence(_) => {}
        }
    }
}
