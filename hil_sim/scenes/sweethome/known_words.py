"""The words that drawn things go by, in a few languages. No accents; `_` stands for a space."""

ETEKS = {
    "bed140x190": "bed", "bed90x190": "bed", "bunkBed90x190": "bed", "cornerBunkBed90x190": "bed",
    "loftBed140x190": "bed", "bed": "bed", "crib": "bed", "chest": "dresser",
    "bedsideTable": "nightstand", "bookcase": "bookcase", "filledBookcase": "bookcase",
    "chair": "chair", "chair2": "chair", "armchair": "armchair", "armchair2": "armchair",
    "roundTable": "table", "squareTable": "table", "table": "table", "coffeeTable": "coffee table",
    "toiletUnit": "toilet", "washbasin": "sink", "washbasinWithCabinet": "sink", "sink": "sink",
    "bath": "bathtub", "fittedBath": "bathtub", "shower": "shower", "plant": "plant",
    "flowers": "plant", "clothesWasher": "washing machine", "cooker": "stove", "oven": "stove",
    "fridge": "refrigerator", "fridgeFreezer": "refrigerator", "kitchenCabinet": "cabinet",
    "kitchenUpperCabinet": "cabinet", "glassDoorCabinet": "cabinet", "piano": "piano",
    "sofa": "sofa", "sofa2": "sofa", "cornerSofa": "sofa", "stool": "stool",
    "tvUnit": "television", "flatTV": "television", "wardrobe": "wardrobe", "desk": "desk",
    "laptop": "laptop", "dresser": "dresser", "fireplace": "fireplace", "frame": "picture",
    "lamp": "lamp", "floorUplight": "lamp", "wallUplight": "lamp", "pendantLamp": "lamp",
    "workLamp": "lamp", "spotlight": "lamp", "electricRadiator": "radiator",
    "hotWaterRadiator": "radiator",
}  # fmt: skip
"""Sweet Home 3D's own catalogue; its other pieces (boxes, stairs, hood, ...) are "other"."""

WORDS = {
    "bed": "bed daybed four_poster bettgestell bettrahmen cadre_de_lit cot crib lit berceau bett "
    "kinderbett doppelbett cama cuna letto culla",
    "sofa": "sofa couch settee loveseat canape divano sofabed love_seat four_seater hoekbank "
    "zitbank slaapbank loungebank bankstel zits",
    "chair": "chair chaise chaise_bureau stuhl stuhle silla sedia stoel cadeira",
    "armchair": "armchair recliner fauteuil sessel sillon butaca poltrona",
    "table": "table side_table sidetable worktable tisch esstisch mesa tavolo tafel dining_table "
    "kitchen_table table_a_manger mesa_de_comedor",
    "coffee table": "coffee_table table_basse couchtisch mesa_de_centro tavolino salontafel",
    "desk": "desk schreibtisch escritorio scrivania bureau bureautafel workstation",
    "toilet": "toilet wc toilette klo inodoro retrete cuvette_de_toilette water_closet vaso_water "
    "water_sospeso vaso_sanitario sanitario",
    "bathtub": "bathtub bath tub baignoire badewanne wanne banera vasca bad banheira jacuzzi",
    "shower": "shower douche dusche ducha doccia chuveiro shower_cabin shower_tray",
    "sink": "sink washbasin basin lavabo evier waschbecken becken spule spulbecken fregadero "
    "lavandino waschtisch lavello wastafel gootsteen pia handbasin wash_stand",
    "refrigerator": "refrigerator fridge freezer refrigerateur frigo kuhlschrank gefrierschrank "
    "nevera frigorifico frigorifero koelkast geladeira",
    "stove": "stove cooker oven range hob cooktop cuisiniere four herd gasherd elektroherd "
    "backofen estufa horno cocina fornello forno fornuis fogao",
    "microwave": "microwave micro_ondes four_a_micro_ondes mikrowelle microondas microonde "
    "magnetron",
    "television": "television tv televiseur fernseher televisor televisore televisie tele",
    "plant": "plant houseplant potted_plant flower plante fleur pflanze zimmerpflanze blume planta "
    "flor pianta fiore ficus palm",
    "laptop": "laptop notebook ordinateur_portable portatil portatile",
    "wardrobe": "wardrobe armoire kleiderschrank armario closet guardaroba armadio kledingkast "
    "guarda_roupa pax",
    "bookcase": "bookcase bookshelf bookshelves shelf shelves bibliotheque etagere bucherregal "
    "regal estanteria libreria boekenkast estante book_case",
    "cabinet": "cabinet cupboard sideboard buffet placard meuble schrank kuchenschrank "
    "unterschrank hangeschrank oberschrank kommode_tv tv_stand tv_cabinet tv_bench tv_rack "
    "meuble_tv mueble_tv mobile_tv gabinete credenza kast base_cabinet wall_cabinet kitchen_unit",
    "nightstand": "nightstand night_stand bed_stand bedside_table bed_side_table bedside_cabinet "
    "night_table table_de_chevet chevet nachttisch nachtkastchen mesita_de_noche mesilla comodino "
    "nachtkastje criado_mudo",
    "dresser": "dresser chest_of_drawers commode kommode comoda cassettiera ladekast drawers",
    "lamp": "lamp lampe lampadaire light chandelier leuchte spotlight stehlampe tischlampe lampara "
    "lampada floor_lamp table_lamp desk_lamp lampe_bureau ceiling_light wall_light table_light "
    "desk_light floor_light mirror_light picture_light",
    "washing machine": "washing_machine washer clothes_washer lave_linge machine_a_laver "
    "waschmaschine lavadora lavatrice wasmachine dryer tumble_dryer",
    "stool": "stool tabouret hocker taburete sgabello kruk barhocker bar_stool footstool ottoman",
    "trash can": "trash_can trash_bin waste_bin waste_basket paper_basket garbage_can bin "
    "wastebasket dustbin poubelle mulleimer papierkorb papelera cubo_de_basura pattumiera cestino "
    "prullenbak lixeira",
    "vase": "vase florero jarron vaso vaas",
    "clock": "clock horloge pendule uhr wanduhr reloj orologio klok wall_clock",
    "alarm clock": "alarm_clock reveil wecker despertador sveglia wekker",
    "radiator": "radiator heater radiateur heizkorper heizung radiador radiatore",
    "piano": "piano klavier flugel pianoforte grand_piano",
    "fireplace": "fireplace cheminee kamin chimenea camino open_haard lareira",
    "mirror": "mirror miroir spiegel espejo specchio espelho",
    "picture": "picture painting poster frame photo tableau cadre bild gemalde cuadro quadro "
    "schilderij wall_art",
    "apple": "apple pomme apfel manzana mela appel",
    "baseball bat": "baseball_bat batte_de_baseball baseballschlager",
    "basketball": "basketball basket_ball",
    "bowl": "bowl bol schussel schale cuenco ciotola",
    "mug": "mug cup tasse becher taza tazza mok coffee_cup coffee_mug",
    "spray bottle": "spray_bottle spruhflasche vaporisateur",
    "door": "door porte tur puerta porta deur",
    "other": "chest trunk rug carpet teppich curtain curtains vorhang stairs staircase escalier "
    "treppe fahrstuhl dishwasher lave_vaisselle spulmaschine hood hotte car bath_mat bed_linen "
    "linen bench turntable wheelchair brush paper roll holder dispenser bottle cooler towel sheet "
    "cover cloth runner blanket pillow cushion pad mat switch remote remote_control antenna mount "
    "bracket hook hanger handle knob lock hinge bell tap faucet mixer drain pipe hose shade bulb "
    "socket outlet plug cable fan plunger cleaner soap scale caddy tray basket box bag book lid "
    "head headboard stand organizer organiser magnet glove cistern tank door_frame window_frame "
    "toilet_seat table_top counter_top plant_pot flower_pot flower_box water_heater water_boiler "
    "boiler towel_rail towel_rack shower_screen shower_rail bird_bath bath_bomb dog_bed cat_bed "
    "pet_bed flower_bed hundebett katzenbett table_saw table_a_repasser bat gel shampoo robe toy "
    "sponge sign rod cord wire charger lift leg mitt valve stopper radio speaker burste halter "
    "rolle matte decke handtuch kissen schirm schalter fernbedienung",
}
"""Names a category goes by. Those of "other" are here because they follow what they belong to: a
toilet brush is no toilet."""

OTHER_BEFORE = (
    "brosse papier rouleau porte_rouleau porte_papier porte_serviette porte_savon porte_manteau "
    "porte_manteaux porte_parapluie porte_revue porte_bouteille porte_chaussure serviette "
    "rideau tapis interrupteur prise telecommande robinet bouteille couvercle housse coussin "
    "escobilla papel cortina alfombra toalla mando interruptor enchufe grifo botella cojin "
    "scopino spazzola carta portarotolo tenda tappeto asciugamano telecomando interruttore presa "
    "couvre testata rubinetto bottiglia cuscino escova tapete toalha tomada torneira "
    "garrafa almofada"
)
"""Names of nothing that can be a goal, in languages where what it belongs to comes after."""

FAINT = "light frame poster four drawers door porte tur puerta porta deur"
"""Words that mean a piece only where nothing else in the name does: a bed frame is a bed, a light
grey sofa a sofa."""

ALONE = {"water": "toilet", "bank": "sofa"}
"""Words that in one language mean a piece, in others something else: only as the whole name."""

ENDINGS = (
    "bett stuhl tisch sessel schrank regal lampe lamp leuchte spiegel wanne becken "
    "kommode hocker vorhang teppich treppe toilette backofen pflanze heizkorper waschmaschine uhr "
    "sofa couch stoel tafel kast klok chair bureau fridge shelf"
)
"""Ends of compounds that say what the whole is, such as "Einzelbett"."""

ROOMS = {
    "kitchen": ("kitchen kitchenette kit kuche keuken pantry", "cuisine cocina cucina cozinha"),
    "bathroom": (
        "bathroom bath ba toilet toilets wc w_c water_closet shower shower_room restroom washroom "
        "wash_room lavatory ensuite en_suite bad badezimmer gastebad gastewc dusche "
        "badkamer laundry "
        "powder_room",
        "salle_de_bain salle_de_bains salle_bain salle_d_eau salle_de_douche sdb s_d_b sde "
        "toilettes bano cuarto_de_bano sala_de_bano aseo bagno banheiro casa_de_banho "
        "quarto_de_banho lavabo ducha doccia",
    ),
    "bedroom": (
        "bedroom nursery bed br mbr master suite guest guests guest_room kids kids_room parents "
        "childrens_room elternzimmer jugendzimmer schlafzimmer kinderzimmer gastezimmer "
        "eltern kind kinder gaste slaapkamer",
        "chambre chbre dormitorio habitacion alcoba camera camera_da_letto cameretta quarto",
    ),
    "living room": (
        "living living_room living_hall living_dining living_dining_room lr lounge wohnzimmer "
        "stube woonkamer family_room sitting_room drawing_room great_room tv_room winter_garden "
        "wintergarten den wohnen",
        "salon sejour sala sala_de_estar soggiorno salotto jardin_d_hiver",
    ),
    "dining room": (
        "dining dining_room dining_hall breakfast breakfast_nook esszimmer eetkamer essen",
        "salle_a_manger comedor sala_da_pranzo sala_de_jantar",
    ),
    "study": (
        "study office home_office library arbeitszimmer buro studio kantoor werkkamer workroom",
        "bureau despacho estudio ufficio escritorio",
    ),
    "hallway": (
        "hall hallway hall_way corridor entry entrance foyer lobby landing vestibule flur diele "
        "gang eingang hal overloop passage stairs closet walk_in_closet wic walk_in dressing "
        "dressing_room treppenhaus ankleide ankleidezimmer garderobe inloopkast",
        "couloir entree palier pasillo entrada recibidor corridoio ingresso corredor placard "
        "vestidor cabina_armadio disimpegno",
    ),
}
"""Names a room type goes by: in languages in which what a compound is comes last ("Hall bath"), and
in those in which it comes first ("Cuisine salon")."""

FAINT_ROOMS = "bed master suite guest guests kids parents eltern kind kinder gaste"
"""Words that tell a room only where nothing else in its name does: whose it is, mostly."""

SHORT_ENDINGS = "bad wc hal"
"""Of room names with fewer than four letters, those that compounds end in, such as "Elternbad"."""

CUT = (
    "de di da do du for with without of on in en under mit fur unter avec pour con para per met "
    "com a et and"
)
"""What follows one of these only tells more of what came before it."""

GENITIVE = "de di da do du of"
"""Before one of these stands what a thing is: a head of a bed is no bed."""

MANY = "set pair group couple row jeu lot ensemble paire juego conjunto par coppia paar serie"
"""Before "of", these do not tell what a thing is."""

VOTES = {
    "toilet": ("bathroom", 3), "bathtub": ("bathroom", 3), "shower": ("bathroom", 3),
    "bed": ("bedroom", 3), "nightstand": ("bedroom", 1), "wardrobe": ("bedroom", 1),
    "refrigerator": ("kitchen", 3), "stove": ("kitchen", 3), "microwave": ("kitchen", 2),
    "sofa": ("living room", 3), "television": ("living room", 1),
    "coffee table": ("living room", 1), "fireplace": ("living room", 1),
    "table": ("dining room", 1), "chair": ("dining room", 0.3), "desk": ("study", 2),
    "bookcase": ("study", 0.5), "washing machine": ("bathroom", 1), "sink": ("bathroom", 0.5),
}  # fmt: skip
"""What a piece of furniture says of the room that it stands in, and how loudly."""

OUTDOORS = (
    "terrace patio balcony garden yard driveway lawn pool terrasse balkon garten hof jardin cour "
    "balcon terraza patio terrazza balcone giardino cortile tuin terras terraco varanda loggia"
)
"""Rooms of these names are not of the home's inside."""
