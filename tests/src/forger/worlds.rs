//! World files.

use super::case::{Case, Expected, plan, text, words};
use super::mangle;
use crate::generated::Dice;
use rpl_robot::world::World;

const SMALL: &str = "name = \"w\"\nsize = [6.0, 4.0]\nstart = [1.0, 1.0, 0]\n";

/// How a world is used.
fn uses(dice: &mut Dice) -> Vec<String> {
    words(dice.pick(&[
        "worlds w.toml",
        "worlds w.toml --png w.png",
        "worlds w.toml --svg w.svg",
        "run plan.rpl --world w.toml --until 1s",
        "run plan.rpl --world w.toml --map none --until 1s",
        "run plan.rpl --world w.toml --grid coarse --until 1s",
    ]))
}

/// A world file somebody damaged.
pub fn mangled(dice: &mut Dice) -> Case {
    let names: Vec<&str> = World::builtin_names().collect();
    let whole = World::builtin_text(dice.pick(&names)).unwrap_or(SMALL);
    let world = if dice.once_in(4) { mangle::text(SMALL, dice) } else { mangle::text(whole, dice) };
    let files = vec![text("w.toml", world), plan()];
    Case { kind: "mangled world", files, arguments: uses(dice), expected: Expected::Anything }
}

/// A world file with too much of something.
pub fn full(dice: &mut Dice) -> Case {
    let many = [3, 400, 4_000, 40_000][dice.below(4)];
    let repeated = |one: &dyn Fn(usize) -> String| (0..many).map(one).collect::<String>();
    let world = match dice.below(11) {
        0 => format!("{SMALL}{}", repeated(&|at| format!("[[room]]\nname = \"r{at}\"\nrect = [0, 2, 1, 3]\n"))),
        1 => format!("{SMALL}{}", repeated(&|at| format!("[[place]]\nname = \"p{at}\"\npose = [1, 1, 0]\n"))),
        2 => format!("{SMALL}{}", "[[wall]]\n".repeat(many)),
        3 => format!("{SMALL}[[wall]]\nline = [{}]\n", repeated(&|at| format!("[{}, 3],", at % 6))),
        4 => format!("{SMALL}x = {}{}\n", "[".repeat(many), "]".repeat(many)),
        5 => format!("{SMALL}{}", repeated(&|at| format!("k{at} = 1\n"))),
        6 => format!("{SMALL}{}\n", repeated(&|at| format!("a{at}.")) + "z = 1"),
        7 => format!("{SMALL}[[place]]\nname = \"{}\"\npose = [1, 1, 0]\n", "n".repeat(many * 20)),
        8 => format!(
            "{SMALL}{}",
            repeated(&|_| "[[region]]\nmode = \"hallway\"\nrect = [-9e4, -9e4, 9e4, 9e4]\n".to_string())
        ),
        9 => {
            let size = dice.pick(&["1000", "600", "150", "0.6"]).to_string();
            format!("people = 200\nname = \"w\"\nsize = [{size}, {size}]\nstart = [0.3, 0.3, 0]\n")
        }
        _ => {
            SMALL.replace("[6.0, 4.0]", "[900, 900]")
                + &repeated(&|_| "[[wall]]\nline = [[3, 3], [899, 899], [3, 898]]\n".into())
        }
    };
    Case {
        kind: "full world",
        files: vec![text("w.toml", world), plan()],
        arguments: uses(dice),
        expected: Expected::Anything,
    }
}
