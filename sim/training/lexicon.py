"""Words for rooms and things: names, activities, and things that are typical of a room. This module contains only data.

The module `phrases` withholds every third entry of a line from training, so that the choice is not made by hand. In tables
of names, the first entry of a line is the room label or the kind of furniture itself.
"""


def _table(text: str) -> dict[str, tuple[str, ...]]:
    """Parse lines of the form `key: entry, entry, ...`. Indented lines continue the line above; entries keep their order."""
    rows = (line.split(":", 1) for line in text.replace("\n    ", " ").strip().splitlines())
    return {key.strip(): tuple(entry.strip() for entry in entries.split(",")) for key, entries in rows}


ROOMS = _table("""
kitchen: kitchen, cooking area, kitchenette, room for cooking, galley kitchen, cookery room, fitted kitchen, eat-in
    kitchen, cook's room, kitchen area, family kitchen, cookhouse, small kitchen, canteen kitchen, tea kitchen, modern
    kitchen, food preparation room, cooking space
dining room: dining room, dining area, breakfast room, eating area, banquet room, dinette, room for meals, dining hall,
    lunch room, supper room, formal dining room, eating place, dining space, family dining room, meal room, breakfast
    area, dining corner, dinner room
living room: living room, sitting room, lounge, family room, parlour, drawing room, front room, TV room, den, living area,
    reception room with sofas, cosy sitting area, television room, salon, lounge room, home cinema, day room, living space
bedroom: bedroom, room for sleeping, sleeping chamber, master bedroom, guest room, sleeping quarters, bed chamber, spare
    bedroom, dormitory, double bedroom, sleeping room, bed room, main bedroom, guest bedroom, parents' bedroom, chamber
    with a bed, hotel room, boudoir
children's room: children's room, kids room, child's bedroom, room for children, playroom, toy room, nursery, kid's
    bedroom, room for a small child, boy's room, girl's room, baby room, children's bedroom, play area, room for toddlers,
    daughter's room, son's bedroom, kindergarten room
bathroom: bathroom, bath, shower room, washroom, family bathroom, en suite, room with a bathtub, washroom with a shower,
    bathing room, wet room, master bath, full bath, en suite bathroom, room to bathe in, bathing place, guest bathroom,
    bath and shower room, washing and bathing room
toilet: toilet, restroom, lavatory, water closet, WC, half bath, powder room, loo, privy, small toilet room, guest toilet,
    bathroom stall, toilet cubicle, cloakroom toilet, washroom with a toilet only, ladies' room, men's room, latrine
corridor: corridor, hallway, aisle, passage, passageway, narrow hallway, long hall, connecting corridor, gallery between
    rooms, walkway, long corridor, passage between rooms, inner hallway, upstairs hallway, hall with many doors, landing,
    through passage, hotel hallway
entrance hall: entrance hall, entry hall, vestibule, foyer, entryway, entrance area, front hall, hall behind the front
    door, entry, mud room, entrance, porch, front entrance, cloakroom at the door, doorway hall, house entrance, entrance
    room, anteroom
stairs: stairs, staircase, stairway, steps, stairwell, flight of stairs, flight of steps, stair, set of stairs, steps
    leading upstairs, stairs to the upper floor, steps going down, staircase with a railing, steps up, stairs going up,
    steps to the next storey, wooden stairs, set of steps
office: office, study, home office, work room, private office, workspace, study with a desk, single office, bureau,
    personal office, manager's office, work study, room for desk work, small office, writing room, professor's office,
    executive office, home workplace
meeting room: meeting room, conference room, boardroom, room for meetings, discussion room, committee room, briefing room,
    team meeting room, council room, negotiation room, conference hall, room for conferences, meeting space, huddle room,
    assembly room, video conference room, group discussion room, consultation room
open-plan office: open-plan office, shared office, coworking space, large office with many desks, open office, team
    office, cubicles, office floor, bullpen, open workspace, office landscape, call centre, large shared workspace, big
    office, desk area for many people, open-plan workspace, rows of workstations, newsroom
lobby: lobby, reception, reception hall, reception area, waiting area, waiting room, front desk area, building lobby,
    check-in area, hotel lobby, reception room, visitors' area, main lobby, waiting lounge, welcome area, lobby of an
    office building, front desk, concourse
laundry room: laundry room, room for laundry, utility room, washing room, laundry, launderette, laundry area, room with a
    washing machine, wash house, drying room, laundry space, ironing room, wash room for clothes, laundry and utility
    room, clothes washing room, room for washing clothes, home laundry, linen room
storage room: storage room, store room, storeroom, box room, stockroom, depot, storage, lumber room, storage space,
    storage closet, junk room, warehouse room, store, supply room, storage cupboard, room full of boxes, attic storage,
    cellar
pantry: pantry, larder, food storage, food store, provisions room, food cupboard, food cellar, food pantry, buttery, food
    closet, room for provisions, food storeroom, kitchen larder, walk-in pantry, food stockroom, pantry cupboard, cold
    store for food, grocery store room
garage: garage, car garage, parking space, room for a car, car port, car park, parking garage, car repair workshop, indoor
    parking, car shed, motor garage, place for the car, car workshop, double garage, vehicle shed, garage workshop, car
    house, vehicle bay
garden: garden, yard, back garden, backyard, lawn, outdoors, outdoor garden, green space, lawn with flowers, flower
    garden, front yard, vegetable garden, garden with trees, courtyard garden, grounds, park, grassy yard, outdoor green
    area
balcony: balcony, terrace, patio, roof terrace, loggia, deck, veranda, open-air balcony, sun deck, rooftop terrace,
    balcony with a railing, small terrace, outdoor balcony, roof deck, outdoor terrace, balustrade, apartment balcony, sun
    terrace
gym: gym, fitness room, workout room, exercise room, weight room, fitness studio, training room, gymnasium, sports room,
    home gym, fitness centre, weight training room, exercise studio, health club, sports hall, workout space, gym hall,
    bodybuilding room
library: library, reading room, book collection, book room, room full of books, reading hall, archive of books, library
    hall, bookshop, public library, home library, book archive, school library, reading area, house of books, library
    room, room with many bookshelves, literature collection
classroom: classroom, school room, lecture hall, lecture room, seminar room, schoolroom, teaching room, school classroom,
    auditorium for lessons, room for lessons, class, school hall, training classroom, pupils' room, lesson room, course
    room, tuition room, primary school classroom
laboratory: laboratory, science lab, chemistry lab, lab, research laboratory, test lab, chemistry room, biology lab,
    experiment room, science room, research lab, physics laboratory, lab room, science laboratory, medical laboratory,
    testing laboratory, chemical laboratory, research room
print room: print room, copy room, copying room, printer room, room with a copier, photocopy room, room with printers,
    printing room, copier room, print shop, copy centre, reprographics room, print area, copy area, duplicating room,
    printing area, print and copy room, photocopying area
""")
"""Names of rooms by room label. The first name is the label itself."""

ACTIVITIES = _table("""
kitchen: cook, cook dinner, fry an egg, boil water, make coffee, wash the dishes, bake a cake, prepare a meal, heat up
    food, chop vegetables, make a sandwich, get a cold drink
dining room: eat dinner, have lunch, sit at the table for a meal, have breakfast together, dine with guests, eat with the
    family, serve a meal, share a meal, host a dinner party
living room: watch television, relax on the sofa, watch a film, sit on the couch, play video games, chill out in the
    evening, lounge around, watch TV with the family, sit by the fireplace
bedroom: sleep, go to bed, take a nap, lie down, rest at night, get some sleep, get dressed, keep my clothes, spend the
    night
children's room: play with toys, let the kids play, build with toy blocks, put the children to bed, read a bedtime story,
    keep toys, play with dolls, put the baby to sleep, play as a child
bathroom: take a bath, take a shower, have a shower, brush my teeth, bathe, wash my body, wash my hair, shave, freshen up
    in the morning, wash my hands
toilet: use the toilet, go to the loo, relieve myself, pee, powder my nose, do my business, go to the toilet, flush the
    toilet, answer nature's call
corridor: walk from room to room, pass through to other rooms, get to the other rooms, walk along, go down the hall, walk
    between rooms, move between rooms, cross to another room, find the doors to all rooms
entrance hall: hang up my coat, take off my shoes, leave the umbrella, come into the house, put on my shoes, leave my
    jacket, enter the house, leave the house, welcome guests at the door
stairs: go upstairs, climb to the next floor, go down to the lower floor, walk up the steps, change floors, get to the
    upper floor, go downstairs, reach the floor above, climb up
office: work at a desk, write emails, do paperwork, work on a computer, work alone, write a report, concentrate on work,
    study for an exam, make phone calls
meeting room: hold a meeting, give a presentation, discuss with the team, have a conference, meet colleagues, have a
    discussion, present slides, hold a video call with the team, talk business around a table
open-plan office: work next to many colleagues, work at one of many desks, sit with the whole team at computers, share an
    office, find a free desk among many, work in a big team, work side by side at desks, work in an open space, sit in a
    cubicle
lobby: wait for someone, check in at the reception, ask the receptionist, meet visitors, register as a visitor, be
    received as a guest, wait to be called, ask at the front desk, sit and wait
laundry room: wash clothes, do the laundry, iron shirts, dry clothes, dry the washing, wash dirty clothes, fold the
    laundry, put on a wash, hang up wet clothes
storage room: store things, keep old boxes, stow away suitcases, put things away, keep things that are not needed, leave
    boxes, find the ladder, store luggage, keep the vacuum cleaner
pantry: store food, keep groceries, keep canned food, find jars and cans, stock up on food, store provisions, get some
    flour and sugar, keep preserves, find something to eat in store
garage: park a car, park the car, leave the vehicle, repair a car, fix the bike, change a tyre, get into the car, keep the
    bicycle, find tools to repair things
garden: plant flowers, mow the lawn, grow vegetables, sit on the grass, play outside, sit under a tree, water the plants,
    have a barbecue, enjoy nature
balcony: sit outside upstairs, look down on the street, get fresh air upstairs, enjoy the view from above, sunbathe
    upstairs, stand outside on an upper floor, have a drink outdoors with a view, look over the railing, step outside for
    air
gym: work out, lift weights, do exercises, run on a treadmill, do sports, train my muscles, exercise, do yoga, get fit
library: read a book, borrow books, find a novel, read quietly, look something up in a book, browse bookshelves, study old
    books, find something to read, return a borrowed book
classroom: teach pupils, learn at school, hold a lesson, attend a class, teach mathematics, give a lecture to pupils,
    learn to read and write, write on the blackboard, listen to the teacher
laboratory: do an experiment, do chemistry, use a microscope, analyse samples, test chemicals, examine cells, mix
    chemicals, do research in a lab coat, handle test tubes
print room: print documents, make photocopies, scan papers, copy a document, print a report, make copies, pick up a
    printout, photocopy a letter, get printer paper
""")
"""Activities in rooms by room label, as verb phrases that can follow "to"."""

THINGS = _table("""
kitchen: stove, fridge, cooking hob, oven, kitchen counter, kitchen appliances, kettle, cooker hood, pots and pans,
    microwave, kitchen island, cooking utensils, dishwasher, kitchen cabinets, crockery, kitchen sink, toaster, fridge
    freezer, spice rack, dish rack
dining room: dining table, dining chairs, set table, china cabinet, chandelier above a table, plates and glasses, dinner
    table, long table with chairs, candlestick on a table
living room: sofa, television, couch, coffee table, armchair, TV set, fireplace, TV stand, settee, piano, sofa and a rug,
    game console
bedroom: double bed, wardrobe, nightstand, bed, bedside table, king-size bed, dresser, vanity, pillows and blankets, alarm
    clock by a bed, big bed, closet for clothes
children's room: bunk bed, teddy bear, toys, cot, toy blocks, stuffed animal, toy shelf, play tent, baby crib, crayons,
    small chairs and toys, building bricks
bathroom: bathtub, shower, tub, bath mat, washbasin and a mirror, shower cabin, towel rail, bath, shower stall, bathroom
    mirror, towels, bathroom sink
toilet: toilet bowl, toilet paper, toilet seat, hand basin and a toilet, flush toilet, toilet brush, toilet and nothing
    else, cistern, commode
corridor: doors on both sides, long carpet runner, row of doors, many doors, narrow long walls, long narrow carpet,
    pictures along a narrow wall, doors to other rooms, long empty walls
entrance hall: coat hooks, shoe rack, coat rack, door mat, umbrella stand, hat stand, key board, front door, row of
    jackets, hall bench, shoes by the door, doormat
stairs: steps, handrail, stair treads, banister, steps and a railing, steep steps, railing, wooden steps, newel post
office: desk, office chair, computer desk, desk with a computer, file cabinet, filing cabinet, desk lamp and papers,
    binders on a shelf, swivel chair
meeting room: meeting table, conference chairs, conference table, wall screen, large table with many chairs, projector
    screen, flip chart, whiteboard and a big table, presentation board
open-plan office: rows of desks, many desks with monitors, many computers, double desks, lots of office chairs, many
    workstations, dozens of screens, several desks in a row, desks for many people
lobby: reception desk, brochure rack, front desk, waiting chairs, reception counter, leaflets and magazines, sofas for
    visitors, visitor seats, receptionist
laundry room: washing machine, tumble dryer, washer, ironing board, drying rack, clothes horse, laundry basket,
    detergents, clothes dryer, folded laundry, washing powder, iron
storage room: cardboard boxes, metal shelf, moving boxes, suitcases, ladder, luggage, plastic bins, paint cans, storage
    shelves, vacuum cleaner and boxes, mop and bucket, stacked crates
pantry: shelves of food, jars, canned food, pantry shelf, food supplies, jars of jam, crates of fruit, cans and jars,
    groceries
garage: car, tool board, automobile, workbench, tyre stack, vehicle, bicycle and tools, tool chest, spare wheels, parked
    car, lawn mower, hand tools
garden: tree, hedge, bushes, flower bed, lawn, grass, garden bench, garden shed, flowers, swing, barbecue, sandpit,
    stepping stones, watering can, grill
balcony: balcony railing, sun lounger upstairs, deck chair above the street, railing with a view, planters on a railing,
    view over the roofs, small outdoor table, parasol on a terrace, balustrade
gym: treadmill, weight bench, dumbbells, exercise bike, weight rack, barbell, gym ball, yoga mat, running machine,
    punching bag, wall bars, fitness machines
library: bookshelves, many books, bookcase, rows of bookshelves, reading table, books, book cart, reading chair, shelves
    full of novels
classroom: blackboard, school desks, chalkboard, teacher's desk, school chairs, rows of desks for pupils, world map and
    desks, globe, chalk
laboratory: microscope, lab bench, test tubes, fume hood, lab stool, glass flasks, laboratory glassware, gas cylinder,
    beakers, analyser, lab instruments, scientific equipment
print room: photocopier, printer, copier, copy counter, paper boxes, copying machine, printers, stacks of paper, laser
    printer
""")
"""Things by room label. They stand in rooms of this label and hardly anywhere else."""

SYNONYMS = _table("""
armchair: armchair, easy chair, padded chair
ball: ball, toy ball, football
bar stool: bar stool, high stool, counter stool
barbecue: barbecue, grill, charcoal grill
bathroom mirror: bathroom mirror, mirror above a basin, shaving mirror
bathtub: bathtub, bath, tub, bath tub, bathing tub, soaking tub
bicycle: bicycle, bike, cycle
blackboard: blackboard, school blackboard, chalkboard
boiler: boiler, water heater, heating boiler
bookshelf: bookshelf, shelf with books, bookcase, shelf full of books, books on shelves, books
bunk bed: bunk bed, bunk, two-storey bed
car: car, parked car, automobile, motor car, family car, vehicle
cardboard boxes: cardboard boxes, moving boxes, cartons
ceiling lamp: ceiling lamp, ceiling light, hanging lamp
chandelier: chandelier, crystal chandelier, candelabra
china cabinet: china cabinet, glass cabinet, display cabinet
coat hooks: coat hooks, hooks for coats, coat rack, hanging coats, clothes hooks, hat rack
coffee table: coffee table, low table, sofa table
conference chair: conference chair, meeting chair, boardroom chair
cooker hood: cooker hood, extractor hood, range hood
cot: cot, baby bed, crib
desk: desk, writing desk, work desk
desk lamp: desk lamp, reading lamp, lamp on a desk
detergents: detergents, washing powder, laundry soap
dining chair: dining chair, chair at a table, kitchen chair
dining table: dining table, table for meals, dinner table, table for eating, family table, table to eat at
dishwasher: dishwasher, dish washing machine, machine for dishes
door mat: door mat, mat at the door, doormat
double bed: double bed, bed, king-size bed, large bed, bed for two, bed with pillows
dresser: dresser, chest of drawers, drawers for clothes
drying rack: drying rack, rack for drying clothes, clothes horse
exercise bike: exercise bike, stationary bicycle, spinning bike
file cabinet: file cabinet, cabinet for files, filing cabinet
fire extinguisher: fire extinguisher, extinguisher, red fire bottle
fireplace: fireplace, open fire, hearth
flip chart: flip chart, paper chart on a stand, flipchart
floor lamp: floor lamp, standing lamp, tall lamp
flower bed: flower bed, bed of flowers, blossoms
fridge: fridge, refrigerator, cool box, fridge freezer, large refrigerator, freezer
fruit bowl: fruit bowl, bowl of fruit, bowl with apples
fume hood: fume hood, fume cupboard, laboratory hood
game console: game console, video game console, gaming machine
garden bench: garden bench, bench outdoors, park bench
garden chair: garden chair, outdoor chair, lawn chair
garden shed: garden shed, tool shed in a garden, garden hut
garden table: garden table, outdoor table, patio table
glassware: glassware, glass flasks, test tubes
globe: globe, terrestrial globe, model of the earth
gym ball: gym ball, exercise ball, fitness ball
hand basin: hand basin, small sink, small washbasin
hedge: hedge, row of bushes, shrubs
ironing board: ironing board, board for ironing, iron
keyboard: keyboard, computer keyboard, keys to type on
kitchen counter: kitchen counter, kitchen worktop, countertop
kitchen sink: kitchen sink, sink, sink with a tap
lab bench: lab bench, laboratory bench, laboratory table
ladder: ladder, step ladder, stepladder
laptop: laptop, notebook computer, portable computer
laundry basket: laundry basket, basket of clothes, hamper
lawn mower: lawn mower, grass cutter, mower
magazines: magazines, journals, newspapers
meeting table: meeting table, table for meetings, conference table
metal shelf: metal shelf, steel shelf, storage rack
microscope: microscope, optical microscope, instrument to magnify cells
microwave: microwave, microwave oven, appliance to warm up food
monitor: monitor, computer screen, computer display
mop bucket: mop bucket, bucket and mop, cleaning bucket
mug: mug, coffee mug, cup
nightstand: nightstand, table beside the bed, bedside table
notice board: notice board, pin board, bulletin board
office chair: office chair, swivel chair, desk chair
paint cans: paint cans, pots of paint, tins of paint
pantry shelf: pantry shelf, shelf with food, shelves of preserves
paper boxes: paper boxes, boxes of paper, reams of paper
photocopier: photocopier, copy machine, copier, copying machine, office copier, xerox machine
piano: piano, upright piano, musical instrument with keys
picture: picture, framed picture, painting
plant: plant, house plant, indoor plant
planter: planter, plant box, flower trough
poster: poster, wall poster, placard
potted plant: potted plant, plant in a pot, pot plant
printer: printer, laser printer, printing machine
punching bag: punching bag, boxing bag, punch bag
radiator: radiator, heater, heating radiator
reading chair: reading chair, chair for reading, comfortable chair for reading
reading table: reading table, table for reading, table to read at
reception desk: reception desk, reception counter, front desk
rug: rug, carpet, floor rug
sandpit: sandpit, sandbox, box of sand to play in
school chair: school chair, pupil's chair, small school seat
school desk: school desk, pupil's desk, student desk
shoe rack: shoe rack, rack for shoes, shoe shelf
shower: shower, shower cubicle, shower cabin
sideboard: sideboard, buffet cabinet, credenza
single bed: single bed, narrow bed, bed for one
sofa: sofa, settee, couch, sofa with cushions, upholstered sofa, divan
spice rack: spice rack, shelf of spices, spices
standing mirror: standing mirror, tall mirror, full-length mirror
stove: stove, cooker, oven, kitchen stove, cooking range, hob
suitcase: suitcase, travel bag, luggage
sun lounger: sun lounger, lounger, deck chair
swing: swing, child's swing, garden swing
table lamp: table lamp, small lamp, bedside lamp
teddy bear: teddy bear, toy bear, stuffed animal
television: television, TV, TV set, television screen, flat screen television, telly
toaster: toaster, bread toaster, machine for toast
toilet bowl: toilet bowl, toilet, toilet seat, flush toilet, lavatory pan, commode
toilet paper: toilet paper, paper roll, toilet roll
tool board: tool board, tools on the wall, wall of tools
tool chest: tool chest, toolbox, box of tools
towel rail: towel rail, towels, towel rack
toy blocks: toy blocks, building blocks, toy bricks
toy shelf: toy shelf, toys, shelf of toys
treadmill: treadmill, running treadmill, running machine
tree: tree, apple tree, tree with leaves
tumble dryer: tumble dryer, dryer, clothes dryer
tyre stack: tyre stack, car tyres, spare wheels
umbrella stand: umbrella stand, umbrellas, umbrella holder
vacuum cleaner: vacuum cleaner, hoover, vacuum
vanity: vanity, dressing table, make-up table
vase: vase, flower vase, vase of flowers
wall clock: wall clock, clock, clock on the wall
wall screen: wall screen, large screen, presentation screen
wardrobe: wardrobe, clothes cupboard, closet, armoire, cupboard for clothes, clothes closet
washbasin: washbasin, sink in a bathroom, wash basin, bathroom sink, wash stand, basin to wash hands
washing machine: washing machine, machine for washing clothes, washer, clothes washer, front-loading washer, laundry
    machine
waste bin: waste bin, rubbish bin, trash can
water cooler: water cooler, water dispenser, drinking water machine
weight bench: weight bench, bench press, bench for lifting weights
weight rack: weight rack, dumbbells, barbell
whiteboard: whiteboard, white board, dry-erase board
window: window, glass window, window pane
workbench: workbench, work bench, bench with tools
world map: world map, map of the world, map of the continents
yoga mat: yoga mat, mat for exercises, gymnastics mat
""")
"""Names by kind of furniture. A kind that is not listed has only its own name."""
