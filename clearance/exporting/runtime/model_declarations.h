#define ROOM(count) ((count) > 0 ? (count) : 1)
/* kinds of spots: a film alone, a contact that begins with a touch, one that sets in gradually */
enum { FILM, CONTACT, BLENDED };

extern const char model_name[];
extern const double state_start[], work_start[], number_start[], spot_band[];
extern const char *const number_names[], *const output_names[], *const output_units[];
extern const char *const spot_names[];
extern const int spot_kind[], spot_place[], spot_places[], drive_start[], drive_speed[];
extern const int input_order[]; /* of inputs among those that `direction` takes */
extern const int input_place[]; /* of these among the numbers of kernels */
extern const double direction_size[];
extern const double rodas_a[], rodas_c[], rodas_h[], rodas_d[], rodas_nodes[];
extern const double ledger_c[], ledger_a[], ledger_basis[];

/* numbers of kernels, natural sizes of states, free ways of spots, typical speeds of gradual
   contacts (else -1) and kinks of laws of time, all from parameters and inputs p */
void numbers(const double *p, double *par, double *size, double *reach, double *typical,
             double *kink);
/* numbers that follow from other numbers */
void derive(double *par);

/* rates of states; derivatives by states without energies, row by row; penetration, its rate and
   contact force of each spot; all outputs; what goes on to the next step; derivatives of rates and
   outputs along dy of states, drive angles and inputs */
void rhs(double t, const double *y, const double *par, const double *work, double *out);
void jacobian(double t, const double *y, const double *par, const double *work, double *out);
void events(double t, const double *y, const double *par, const double *work, double *out);
void observe(double t, const double *y, const double *par, const double *work, double *out);
void commit(double t, const double *y, const double *par, const double *work, double *out);
void direction(double t, const double *y, const double *par, const double *work, const double *dy,
               double *out);

#endif
