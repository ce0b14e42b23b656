//! Pictures of the building with its places (Fox and Anderson-Sprecher, Fig. 3) and of routes as they were
//! retrieved, generated and cut (Fig. 4).

use super::route_rows::RouteRow;
use rpl_drive::show::place_figures;
use rpl_robot::world::World;
use rpl_rupart::places::Places;
use rpl_rupart::trial::RouteAsked;

/// Routes of a row that are drawn: those with the most generated steps of the first run.
const DRAWN: usize = 2;

/// The building, and some routes of each row, as files.
pub fn files(world: &World, places: &Places, rows: &[(&RouteRow, Vec<Vec<RouteAsked>>)]) -> Vec<(String, String)> {
    let mut files = vec![("places.svg".to_string(), place_figures::building(world, places))];
    for (row, runs) in rows {
        let mut adapted: Vec<&RouteAsked> =
            runs.iter().take(1).flatten().filter(|asked| asked.case.is_some()).collect();
        adapted.sort_by_key(|asked| std::cmp::Reverse(asked.adapted.generated_steps));
        for (number, asked) in (1..).zip(adapted.into_iter().take(DRAWN)) {
            let name = format!("{}-{number}.svg", row.name.replace([' ', ','], "-").replace("--", "-"));
            let title = format!("{}: {:.2} times as long as the quickest", row.name, asked.ratio);
            let case = asked.case.as_ref();
            files.push((name, place_figures::adaptation(&title, world, places, case, &asked.adapted.route)));
        }
    }
    files
}
